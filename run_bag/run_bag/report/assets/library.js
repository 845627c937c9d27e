"use strict";
// Unpacks plotly.js, which travels in the page as gzip in base64. window.plotlyLibraries: a promise of the bundles by name.
window.plotlyLibraries = (async () => {
  const found = {};
  for (const holder of document.querySelectorAll("script.library")) {
    if (!("DecompressionStream" in window)) throw new Error("this browser cannot unpack the plots: one of 2023 or later can");
    const bytes = Uint8Array.from(atob(holder.textContent), (letter) => letter.charCodeAt(0));
    const packed = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    const script = document.createElement("script");
    script.textContent = await new Response(packed).text();
    document.head.append(script);
    found[holder.dataset.name] = window.Plotly;
    script.remove();
    holder.remove();
  }
  return found;
})();
