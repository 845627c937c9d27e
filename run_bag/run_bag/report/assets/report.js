"use strict";
// Draws plots when they come near the screen, follows the colour scheme and the width, runs the legend, prepares
// printing. For tests and tools: reportReady, reportErrors, reportDrawAll().
(() => {
  const setup = JSON.parse(document.getElementById("setup").textContent);
  const boxes = [...document.querySelectorAll(".plot")];
  const darkQuery = matchMedia("(prefers-color-scheme: dark)");
  const coarse = matchMedia("(pointer: coarse)").matches;
  const hovers = matchMedia("(hover: hover)").matches;
  const NARROW = 560;
  const PRINT_WIDTH = 670; // A4 minus margins, in CSS pixels
  let printing = false;
  let libraries = null; // of plotly.js by name, once they are unpacked

  const isDark = () => darkQuery.matches && !printing;
  const columnsOf = (box) => Number(box.parentElement.style.getPropertyValue("--columns")) || 1;
  const widthOf = (box) => (printing ? Math.floor(PRINT_WIDTH / columnsOf(box)) - 8 : box.clientWidth);

  // Series colours are written in light; a whole JSON string that is one of them is exchanged for its dark partner.
  function described(box) {
    const text = box.dataset.json;
    const swap = (match, colour) => (colour in setup.partners ? `"${setup.partners[colour]}"` : match);
    return JSON.parse(isDark() ? text.replace(/"(#[0-9a-f]{6}|rgba\([^"]*\))"/g, swap) : text);
  }

  function fitted(layout, box, data) {
    const width = widthOf(box);
    const narrow = width < NARROW;
    const heat = data.some((trace) => trace.type === "heatmap");
    const sideways = data.some((trace) => trace.orientation === "h");
    const own = layout.margin || {};
    layout.template = isDark() ? setup.dark : setup.light;
    layout.autosize = false;
    layout.width = width;
    layout.height = Number(box.dataset.height);
    layout.font = { ...layout.font, size: narrow ? 11 : 12.5 };
    layout.margin = { l: heat || sideways ? 10 : narrow ? 46 : 62, r: narrow ? 8 : 14, t: 10, b: 46, ...own };
    layout.showlegend = false;
    layout.uirevision = "kept";
    if (layout.scene && coarse) layout.scene.dragmode = false;
    if (layout.scene && layout.scene.camera) { // the view is as high as the box: what is narrow is seen from further away
      const eye = layout.scene.camera.eye;
      const away = Math.max(1, (1.1 * layout.height) / width);
      layout.scene.camera.eye = { x: eye.x * away, y: eye.y * away, z: eye.z * away };
    }
    layout.dragmode = coarse ? false : layout.dragmode || "zoom"; // a finger scrolls the page; a tap shows values
    if (narrow && layout.hovermode === "x unified") layout.hovermode = "closest";
    for (const name of Object.keys(layout)) {
      if (/^xaxis/.test(name) && narrow && !layout[name].tickvals) layout[name].nticks = 6;
    }
    if (narrow && heat) for (const trace of data) trace.showscale = !trace.texttemplate;
    if (narrow && heat) for (const trace of data) trace.textfont = { ...trace.textfont, size: 9 };
    return layout;
  }

  // In space by the bundle for it; everything else by the flat one where there is one.
  const plotly = (figure) =>
    (figure.layout.scene ? libraries.gl3d : libraries.cartesian) || libraries.full || libraries.gl3d;

  function hidden(box) {
    const keys = box.closest("figure").querySelectorAll('.key[aria-pressed="false"]');
    return new Set([...keys].map((key) => key.dataset.group));
  }

  function failed(box, error) {
    window.reportErrors.push(`${box.id}: ${error.message}`);
    box.dataset.drawn = "failed";
    box.textContent = `This plot could not be drawn: ${error.message}.`;
  }

  function draw(box) {
    if (!libraries) return unpacked.then(() => draw(box), (error) => failed(box, error));
    try {
      const figure = described(box);
      const off = hidden(box);
      figure.data.forEach((trace) => { trace.visible = off.has(trace.legendgroup || trace.name) ? false : true; });
      figure.layout.shapes = (figure.layout.shapes || []).filter((shape) => !off.has(shape.name));
      fitted(figure.layout, box, figure.data);
      box.dataset.width = String(figure.layout.width);
      return Promise.resolve(plotly(figure).react(box, figure.data, figure.layout, {
        displaylogo: false, responsive: false, scrollZoom: false, doubleClick: "reset+autosize",
        displayModeBar: hovers && !coarse ? "hover" : false,
        // Named one by one: plotly's own choice includes a button that uploads the chart.
        modeBarButtons: figure.layout.scene
          ? [["toImage"], ["tableRotation", "orbitRotation", "zoom3d", "pan3d"], ["resetCameraDefault3d"]]
          : [["toImage"], ["zoom2d", "pan2d"], ["zoomIn2d", "zoomOut2d", "resetScale2d"]],
        toImageButtonOptions: { format: "svg", filename: box.id },
      })).then(() => { box.dataset.drawn = "yes"; });
    } catch (error) {
      failed(box, error);
      return Promise.resolve();
    }
  }

  for (const box of boxes) {
    const source = box.querySelector("script");
    box.dataset.json = source.textContent;
    source.remove();
  }

  const unpacked = window.plotlyLibraries.then((found) => { libraries = found; });

  // Near the screen: draw. A box that changed its width: draw again.
  const near = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (entry.isIntersecting && !entry.target.dataset.drawn) {
        entry.target.dataset.drawn = "pending";
        draw(entry.target);
      }
    }
  }, { rootMargin: "800px 0px" });
  const redrawAll = () => Promise.all(boxes.filter((box) => box.dataset.drawn === "yes").map(draw));
  let timer = 0;
  const resized = new ResizeObserver(() => {
    clearTimeout(timer);
    timer = setTimeout(() => {
      if (printing) return;
      const changed = (box) => box.dataset.drawn === "yes" && Number(box.dataset.width) !== box.clientWidth;
      boxes.filter(changed).forEach(draw);
    }, 120);
  });
  for (const box of boxes) { near.observe(box); resized.observe(box); }

  window.reportDrawAll = () => Promise.all(boxes.map((box) => {
    if (box.dataset.drawn === "yes" || box.dataset.drawn === "failed") return null;
    return draw(box);
  })).then(() => boxes.length);

  darkQuery.addEventListener("change", redrawAll);
  addEventListener("beforeprint", () => {
    printing = true;
    document.querySelectorAll(".download details, .warnings details").forEach((details) => { details.open = true; });
    boxes.forEach(draw);
  });
  addEventListener("afterprint", () => { printing = false; redrawAll(); });

  // Legend: a key hides or shows its series in every plot of its figure.
  document.addEventListener("click", (event) => {
    const key = event.target.closest(".key");
    if (!key) return;
    key.setAttribute("aria-pressed", String(key.getAttribute("aria-pressed") !== "true"));
    key.closest("figure").querySelectorAll('.plot[data-drawn="yes"]').forEach(draw);
  });

  // Contents: open beside the text, folded above it; the current section is marked.
  const wide = matchMedia("(min-width: 1000px)");
  const contents = document.querySelector("nav details");
  const fold = () => { contents.open = wide.matches; };
  wide.addEventListener("change", fold);
  fold();
  contents.addEventListener("click", (event) => {
    if (event.target.closest("a") && !wide.matches) contents.open = false;
  });
  const headings = [...document.querySelectorAll("main h2, main h3")];
  const links = new Map([...document.querySelectorAll("nav a")].map((a) => [a.getAttribute("href").slice(1), a]));
  let waiting = false;
  const mark = () => {
    waiting = false;
    const passed = headings.filter((heading) => heading.getBoundingClientRect().top < innerHeight * 0.25);
    const current = passed.length ? passed[passed.length - 1].id : null;
    for (const [id, a] of links) {
      if (id === current) a.setAttribute("aria-current", "true");
      else a.removeAttribute("aria-current");
    }
  };
  addEventListener("scroll", () => {
    if (!waiting) { waiting = true; requestAnimationFrame(mark); }
  }, { passive: true });
  mark();

  const ready = () => requestAnimationFrame(() => setTimeout(() => { window.reportReady = true; }, 0));
  unpacked.then(ready, ready);
})();
