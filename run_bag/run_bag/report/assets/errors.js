// Collect every error from the first line on, for the tests and for the note below a plot that could not be drawn.
window.reportErrors = [];
window.reportReady = false;
addEventListener("error", (event) => window.reportErrors.push(String(event.message)));
addEventListener("unhandledrejection", (event) => window.reportErrors.push(String(event.reason)));
