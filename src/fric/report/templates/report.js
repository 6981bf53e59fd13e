"use strict";
// Figures are drawings that were made before. Here they are zoomed and moved, read under the pointer, their curves
// hidden, and the error around a circle magnified.
const all = (selector, within = document) => [...within.querySelectorAll(selector)];
const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
const MOST = 200; // how many times a figure is enlarged at most

function zoomable(svg) {
  const { x: left, y: top, width, height } = svg.viewBox.baseVal;
  let [x, y, wide] = [left, top, width];
  const show = (newX, newY, newWide) => {
    wide = clamp(newWide, width / MOST, width);
    x = clamp(newX, left, left + width - wide);
    y = clamp(newY, top, top + height - wide * height / width);
    svg.setAttribute("viewBox", `${x} ${y} ${wide} ${wide * height / width}`);
  };
  const enlarge = (factor, [px, py] = [x + wide / 2, y + wide * height / width / 2]) => {
    const made = clamp(wide / factor, width / MOST, width) / wide;
    show(px - (px - x) * made, py - (py - y) * made, wide * made);
  };
  svg.lookAt = (px, py, half) => show(px - half * width / height, py - half, 2 * half * width / height);
  svg.whole = () => show(left, top, width);

  svg.addEventListener("wheel", (event) => { // of a figure that is in use; else the page is scrolled
    if (document.activeElement !== svg && !event.ctrlKey) return;
    event.preventDefault();
    enlarge(2 ** (-event.deltaY / 400), place(svg, event));
  }, { passive: false });
  svg.addEventListener("dblclick", () => svg.whole());
  svg.addEventListener("pointerdown", (event) => {
    if (event.button) return;
    const from = place(svg, event);
    const move = (later) => { const to = place(svg, later); show(x + from[0] - to[0], y + from[1] - to[1], wide); };
    const end = () => { removeEventListener("pointermove", move); removeEventListener("pointerup", end); };
    addEventListener("pointermove", move);
    addEventListener("pointerup", end);
  });
  svg.addEventListener("keydown", (event) => {
    const step = wide / 10;
    const act = {
      "+": () => enlarge(1.25), "=": () => enlarge(1.25), "-": () => enlarge(0.8), 0: svg.whole, Escape: svg.whole,
      ArrowLeft: () => show(x - step, y, wide), ArrowRight: () => show(x + step, y, wide),
      ArrowUp: () => show(x, y - step, wide), ArrowDown: () => show(x, y + step, wide),
    }[event.key];
    if (!act || event.ctrlKey || event.metaKey || (event.key.startsWith("Arrow") && wide === width)) return;
    event.preventDefault();
    act();
  });
}

// Where a pointer is in a drawing.
function place(svg, event) {
  const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
  return [at.x, at.y];
}

// The numbers under the pointer, from the frames of the panels and their limits.
function readable(svg) {
  const panels = JSON.parse(svg.dataset.panels), told = svg.parentElement.querySelector(".read");
  const value = ([low, high, scale], share) =>
    scale === "log" ? low * (high / low) ** share : low + (high - low) * share;
  const words = (label, number) => label && `${label.replace(/ \[.*/, "")} ${shown(number)} ${/\[(.*)\]/.exec(label)?.[1] ?? ""}`;
  svg.addEventListener("pointermove", (event) => {
    const [px, py] = place(svg, event);
    told.textContent = "";
    for (const { frame, x, y, centre, rim, r } of panels) {
      if (frame && px >= frame[0] && px <= frame[2] && py >= frame[1] && py <= frame[3]) {
        const found = [words(x[3], value(x, (px - frame[0]) / (frame[2] - frame[0]))),
          words(y[3], value(y, (frame[3] - py) / (frame[3] - frame[1])))];
        told.textContent = found.filter(Boolean).join(", ");
      } else if (centre && Math.hypot(px - centre[0], py - centre[1]) <= rim) {
        const angle = (Math.atan2(centre[1] - py, px - centre[0]) * 180 / Math.PI + 360) % 360;
        const error = r[0] + (r[1] - r[0]) * Math.hypot(px - centre[0], py - centre[1]) / rim;
        told.textContent = `${angle.toFixed(1)}°, error ${shown(error / Number(svg.dataset.magnified ?? 1))} µm`;
      }
    }
  });
  svg.addEventListener("pointerleave", () => { told.textContent = ""; });
}

function shown(number) { return String(Number(number.toPrecision(4))).replace("-", "−"); }
function hide(one, hidden) { one.toggleAttribute("data-off", hidden); }

// A click on an entry of a legend hides its curve, and shows it again.
function legends(svg) {
  for (const entry of all('[data-name^="legend:"]', svg)) {
    const number = entry.dataset.name.slice("legend:".length);
    entry.addEventListener("click", () => {
      const curves = all(`[data-name="curve:${number}"]`, svg), hidden = curves.every((one) => "off" in one.dataset);
      for (const one of curves) hide(one, !hidden);
      for (const one of all(`[data-name="legend:${number}"]`, svg)) one.toggleAttribute("data-pale", !hidden);
    });
  }
}

// The controls beside a contour switch its schemes, magnify its error, and look at a reversal.
function control(panel) {
  const svg = panel.querySelector(`#${panel.dataset.figure} svg`);
  const boxes = all(".scheme", panel), earlier = panel.querySelector(".earlier");
  const show = () => {
    for (const box of boxes) {
      for (const one of all(`[data-name="now:${box.value}"]`, panel)) hide(one, !box.checked);
      for (const one of all(`[data-name="earlier:${box.value}"]`, panel)) hide(one, !(box.checked && earlier?.checked));
    }
  };
  for (const box of [...boxes, ...(earlier ? [earlier] : [])]) box.addEventListener("change", show);
  const tick = (value) => () => { for (const box of boxes) box.checked = value; show(); };
  panel.querySelector(".all").addEventListener("click", tick(true));
  panel.querySelector(".none").addEventListener("click", tick(false));
  show();
  if (panel.dataset.magnification) magnifiable(panel, svg);
}

function magnifiable(panel, svg) {
  const drawnWith = Number(panel.dataset.magnification), radius = Number(panel.dataset.radius); // µm
  const { centre: [cx, cy], rim, r: [low, high] } = JSON.parse(svg.dataset.panels)[0];
  const nominal = rim * -low / (high - low); // radius of the circle that was asked for, in the drawing
  const lines = all('[data-name^="now:"] path, [data-name^="earlier:"] path', svg).map((path) => {
    const numbers = path.getAttribute("d").match(/-?[\d.]+/g).map(Number);
    const points = Array.from({ length: numbers.length / 2 }, (_, i) => [numbers[2 * i] - cx, numbers[2 * i + 1] - cy]);
    return [path, points.map(([x, y]) => { const size = Math.hypot(x, y); return [x / size, y / size, size - nominal]; })];
  });
  const rings = [-3, -2, -1, 1, 2], drawn = all('[data-name^="ring:"]', svg);
  const curves = drawn.filter((one) => one.querySelector("path")), labels = drawn.filter((one) => one.querySelector("text"));
  const field = panel.querySelector(".magnification"), slider = panel.querySelector(".slider");

  const magnify = (factor) => {
    for (const [path, points] of lines) {
      path.setAttribute("d", points.map(([x, y, error], i) => {
        const size = Math.max(nominal + error * factor / drawnWith, 0);
        return `${i ? "L" : "M"}${(cx + size * x).toFixed(3)} ${(cy + size * y).toFixed(3)}`;
      }).join(""));
    }
    const step = round(radius / factor / 6);
    rings.forEach((n, i) => {
      const size = nominal * (1 + n * step * factor / radius);
      for (const one of [curves[i], labels[i]]) if (one) hide(one, size < 0.3 * nominal || size > rim);
      curves[i]?.querySelector("path").setAttribute("d", circle(cx, cy, size));
      const text = labels[i]?.querySelector("text");
      if (!text) return;
      text.textContent = `${n > 0 ? "+" : "−"}${Number(Math.abs(n * step).toPrecision(2))} µm`;
      text.removeAttribute("x");
      text.removeAttribute("y");
      text.setAttribute("transform", `translate(${cx + size * Math.SQRT1_2} ${cy - size * Math.SQRT1_2})`);
    });
    svg.dataset.magnified = String(factor / drawnWith);
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
  set(drawnWith);

  for (const button of all(".zoom", panel)) {
    const quadrant = Number(button.dataset.quadrant) * Math.PI / 2;
    button.addEventListener("click", () => {
      if (button.dataset.quadrant === "all") svg.whole();
      else svg.lookAt(cx + 1.1 * nominal * Math.cos(quadrant), cy - 1.1 * nominal * Math.sin(quadrant), 0.4 * nominal);
    });
  }
}

function circle(x, y, r) { return `M${x - r} ${y}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0`; }

// The next of 1, 2, 5 times a power of ten.
function round(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * [1, 2, 5, 10].find((step) => step * power >= value * 0.999);
}

// On paper everything is open, and every figure is whole.
addEventListener("beforeprint", () => {
  for (const one of all("details")) one.open = true;
  for (const svg of all("svg.plot")) svg.whole();
});
for (const svg of all("svg.plot")) { zoomable(svg); readable(svg); legends(svg); }
for (const panel of all(".contour")) control(panel);
document.documentElement.dataset.ready = "yes";
