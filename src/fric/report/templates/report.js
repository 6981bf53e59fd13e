"use strict";
// Draws the figures, and lets the controls beside a contour switch its schemes, magnify its error and zoom.
const read = (id) => JSON.parse(document.getElementById(id).textContent);
const settings = read("settings");
const WHOLE = 1.55; // half of what is seen of a circle, in radii

async function draw() {
  const drawn = {};
  for (const [id, item] of Object.entries(read("figures"))) {
    const views = await Bokeh.embed.embed_item(item, id);
    drawn[id] = views.roots[0].model;
  }
  for (const panel of document.querySelectorAll(".contour")) control(panel, drawn[panel.dataset.figure], drawn);
  document.documentElement.dataset.ready = "yes";
}

function control(panel, plot, figures) {
  const all = (selector) => [...panel.querySelectorAll(selector)];
  const beside = [...panel.querySelectorAll("div.drawn")].map((one) => figures[one.id]).filter(Boolean);
  const line = (name) => plot.renderers.find((one) => one.name === name);
  const lines = plot.renderers.filter((one) => /^(now|earlier):/.test(one.name ?? ""));
  const boxes = all(".scheme");
  const earlier = panel.querySelector(".earlier");

  const show = () => {
    for (const box of boxes) {
      for (const one of beside) {
        for (const shown of one.renderers) if (shown.name === "now:" + box.value) shown.visible = box.checked;
      }
      const before = line("earlier:" + box.value);
      if (before) before.visible = box.checked && Boolean(earlier?.checked);
    }
  };
  for (const box of [...boxes, ...(earlier ? [earlier] : [])]) box.addEventListener("change", show);
  const tick = (value) => () => { for (const box of boxes) box.checked = value; show(); };
  panel.querySelector(".all").addEventListener("click", tick(true));
  panel.querySelector(".none").addEventListener("click", tick(false));
  show();

  const given = settings[panel.dataset.figure];
  if (given?.kind !== "circle") return;
  const radius = given.radius; // mm; errors are in µm
  const grid = plot.renderers.find((one) => one.data_source?.name === "grid").data_source;
  const field = panel.querySelector(".magnification");
  const slider = panel.querySelector(".slider");

  const magnify = (factor) => {
    const place = (angle, error) => {
      const r = radius + factor * error / 1000;
      return [r * Math.cos(angle), r * Math.sin(angle)];
    };
    for (const { data_source: source } of lines) {
      const { angle, error } = source.data;
      const x = new Float32Array(angle.length), y = new Float32Array(angle.length);
      for (let i = 0; i < angle.length; i++) [x[i], y[i]] = place(angle[i] * Math.PI / 180, error[i]);
      source.data = { ...source.data, x, y };
    }
    const step = round(radius * 1000 / factor / 6);
    const errors = [-3, -2, -1, 1, 2].map((n) => n * step).filter((e) => radius + factor * e / 1000 > 0.3 * radius);
    const turn = Array.from({ length: 181 }, (_, i) => i * Math.PI / 90);
    const circles = errors.map((error) => turn.map((angle) => place(angle, error)));
    const marks = errors.map((error) => place(Math.PI / 4, error)); // where no axis reverses
    const label = errors.map((e) => (e > 0 ? "+" : "−") + Number(Math.abs(e).toPrecision(2)) + " µm");
    grid.data = {
      xs: circles.map((points) => points.map((p) => p[0])),
      ys: circles.map((points) => points.map((p) => p[1])),
      label, lx: marks.map((p) => p[0]), ly: marks.map((p) => p[1]),
    };
    panel.dataset.magnification = String(factor);
  };
  const set = (factor, except) => {
    if (!(factor >= 1 && factor <= 1e6)) return;
    if (except !== field) field.value = String(Number(factor.toPrecision(3)));
    if (except !== slider) slider.value = String(Math.log10(factor));
    magnify(factor);
  };
  field.addEventListener("input", () => set(Number(field.value), field));
  slider.addEventListener("input", () => set(Number((10 ** Number(slider.value)).toPrecision(2)), slider));
  set(given.magnification);

  const look = (x, y, half) => {
    const wide = half * plot.inner_width / plot.inner_height; // so that a circle is round
    const [x_range, y_range] = [{ start: x - wide, end: x + wide }, { start: y - half, end: y + half }];
    Object.assign(plot.x_range, x_range);
    Object.assign(plot.y_range, y_range);
  };
  look(0, 0, WHOLE * radius);
  for (const range of [plot.x_range, plot.y_range]) Object.assign(range, { reset_start: range.start, reset_end: range.end });
  for (const button of all(".zoom")) {
    button.addEventListener("click", () => {
      const quadrant = button.dataset.quadrant;
      if (quadrant === "all") return look(0, 0, WHOLE * radius);
      const angle = Number(quadrant) * Math.PI / 2;
      look(1.1 * radius * Math.cos(angle), 1.1 * radius * Math.sin(angle), 0.4 * radius);
    });
  }
}

// The next of 1, 2, 5 times a power of ten.
function round(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * [1, 2, 5, 10].find((step) => step * power >= value * 0.999);
}

// On paper everything is open.
addEventListener("beforeprint", () => { for (const one of document.querySelectorAll("details")) one.open = true; });
draw();
