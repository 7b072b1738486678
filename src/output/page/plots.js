// The series of one or more runs as plots that zoom together.
// SPDX-License-Identifier: BSD-3-Clause
import { unpack, readableNumber, escapeHtml } from "packed";

const UNITS = [[7200, 3600, "h"], [120, 60, "min"], [1, 1, "s"], [1e-3, 1e-3, "ms"], [0, 1e-6, "µs"]];
const DASHES = [[], [6, 4], [2, 3]];
const HEIGHT = 230;

/// Columns by name, and what they are divided by.
export async function unpackSeries(run) {
  const { columns, rows, values } = run.series;
  const all = await unpack(values, Float64Array);
  return Object.fromEntries(columns.map((name, c) => [name, all.subarray(c * rows, (c + 1) * rows)]));
}

const since = (values) => values.map((value) => value - values[0]);

/// Title, whether values are drawn by their size on a logarithm, and curves: name, and values of rows.
function plotsOf(run) {
  const unit = run.momentum ?? 1, turn = run.momentum && run.size ? (run.momentum * run.size) / 2 : 1;
  const drift = run.momentum ? `Drift of momentum, ${run.momentumName}` : "Drift of momentum, kg m/s and kg m²/s";
  return [
    ["Energy, J", true, [["kinetic", (rows) => rows.kinetic], ["dissipated", (rows) => since(rows.dissipated)],
      ["freed by gravity", (rows) => since(rows.gravitational).map((value) => -value)], ["unexplained", (rows) => rows.unexplained]]],
    [drift, true, run.free ? [["linear", (rows) => rows.momentum_drift.map((value) => value / unit)],
      ["angular", (rows) => rows.angular_drift.map((value) => value / turn)]] : []],
    ["Residual of contacts, m/s", true, [["largest", (rows) => rows.residual_max], ["rms", (rows) => rows.residual_rms]]],
    ["Contacts", false, [["contacts", (rows) => rows.contacts]]],
  ];
}

const frame = `
  <div class=controls>
    <label class=part>Rows <select></select></label>
    <label>From <input class=from type=range min=0 max=1000 value=0></label>
    <label>to <input class=to type=range min=0 max=1000 value=1000></label>
    <button class=whole type=button>Whole time</button>
    <span class="note mouse">Drag across a plot to zoom.</span>
  </div>
  <div class=grid></div>`;

export class Plots {
  constructor(element, runs, series) {
    [this.runs, this.series, this.plots] = [runs, series, []];
    element.innerHTML = frame;
    this.find = (name) => element.querySelector(name);
    this.grid = this.find(".grid");
    this.column = "rms_speed";
    this.offerParts();
    this.find(".part select").addEventListener("change", () => this.build());
    for (const name of [".from", ".to"]) this.find(name).addEventListener("input", () => this.slide());
    this.find(".whole").addEventListener("click", () => this.zoom(...this.reach));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.build());
    new ResizeObserver(() => this.fit()).observe(this.grid);
    this.build();
  }

  offerParts() {
    const hit = this.runs.some((run) => run.impact !== null);
    const parts = hit ? [["since", "since the impact"], ["until", "up to the impact"], ["all", "all"]] : [["all", "all"]];
    this.find(".part select").innerHTML = parts.map(([value, text]) => `<option value=${value}>${text}`).join("");
    this.find(".part").hidden = !hit;
  }

  /// More rows have come: a part of the time that was chosen stays.
  renew() {
    const chosen = this.find(".part select").value, held = this.range && this.range.some((x, k) => x !== this.reach[k]) && this.range;
    this.offerParts();
    if (chosen !== "all") this.find(".part select").value = chosen;
    this.build();
    if (held) this.zoom(...held);
  }

  /// Rows of a run that belong to the part that is chosen, and their x.
  chosen(k, part) {
    const rows = this.series[k], impact = this.runs[k].impact, time = rows.time;
    const isIn = (t) => part === "all" || impact === null || (part === "since" ? t >= impact : t < impact);
    const places = [...time.keys()].filter((row) => isIn(time[row]));
    const picked = Object.fromEntries(Object.entries(rows).map(([name, values]) => [name, Float64Array.from(places, (row) => values[row])]));
    let x = Array.from(picked.time, (t) => (part === "since" ? t - (impact ?? 0) : t));
    // The first row stands at 0, where a logarithm ends: half a step of the next.
    if (part === "since" && x.length > 1) x[0] = Math.max(x[0], x[1] / 2);
    return { rows: picked, x };
  }

  build() {
    const part = this.find(".part select").value;
    this.parts = this.runs.map((_, k) => this.chosen(k, part));
    const last = Math.max(...this.parts.map(({ x }) => x.at(-1) ?? 0));
    const [, unit, unitName] = UNITS.find(([limit]) => last > limit) ?? UNITS.at(-1);
    this.parts.forEach((one) => { one.x = one.x.map((t) => t / unit); });
    this.logTime = part === "since";
    this.timeName = `time${part === "since" ? " since the impact" : ""}, ${unitName}`;
    this.plots.forEach((plot) => plot.destroy());
    this.plots = [];
    this.grid.innerHTML = "";
    const xs = this.parts.flatMap(({ x }) => (x.length ? [x[0], x.at(-1)] : []));
    this.reach = [Math.min(...xs), Math.max(...xs)];
    if (!(this.reach[1] > this.reach[0])) {
      this.grid.innerHTML = "<p class=note>There are fewer than two rows to draw.</p>";
      return;
    }
    const first = plotsOf(this.runs[0]);
    for (const [k, [title, log]] of first.entries())
      this.add(title, log, this.runs.map((run) => plotsOf(run)[k][2]));
    this.addAny();
    this.zoom(...this.reach);
  }

  /// One plot; none where there is nothing to see. `curves`: a list for each run.
  add(title, log, curves, box = this.box(title)) {
    const tables = [], lines = [], style = getComputedStyle(this.grid);
    curves.forEach((list, k) => {
      const { rows, x } = this.parts[k], table = [x];
      list.forEach(([name, of], c) => {
        const values = Array.from(of(rows), (value) => (log ? Math.abs(value) || null : value));
        if (!values.some((value) => value)) return;
        table.push(values);
        lines.push({ label: this.runs.length > 1 ? `${this.runs[k].name}: ${name}` : name, dash: DASHES[k % DASHES.length], spanGaps: true,
          stroke: style.getPropertyValue(`--line${this.runs.length > 1 && list.length === 1 ? k + 1 : c + 1}`), width: 1.6,
          points: { show: x.length < 12 }, value: (_, value) => (value === null ? "" : readableNumber(value, 4)) });
      });
      tables.push(table);
    });
    if (!lines.length) {
      box.parentElement.remove();
      return;
    }
    const ink = style.getPropertyValue("--ink2"), grid = { stroke: style.getPropertyValue("--rule"), width: 1 };
    const isPower = (value) => Math.abs(Math.log10(value) - Math.round(Math.log10(value))) < 1e-6;
    const lines10 = (isLog) => (isLog ? { ...grid, filter: (_, splits) => splits.map((value) => (isPower(value) ? value : null)) } : grid);
    const ticks = (isLog) => (_, splits) => splits.map((value) => (value === null ? "" : !isLog ? readableNumber(value)
      : isPower(value) ? `1e${Math.round(Math.log10(value))}` : ""));
    const axis = { stroke: ink, ticks: { show: false }, font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif" };
    this.plots.push(new uPlot({
      width: Math.max(200, box.clientWidth), height: HEIGHT, cursor: { drag: { x: true, y: false }, points: { size: 6 } },
      scales: { x: { time: false, distr: this.logTime ? 3 : 1 }, y: { distr: log ? 3 : 1 } },
      axes: [{ ...axis, grid: lines10(this.logTime), label: this.timeName, labelSize: 20, size: 32, values: ticks(this.logTime) },
        { ...axis, grid: lines10(log), size: 58, values: ticks(log) }],
      series: [{ label: "time", value: (_, value) => (value === null ? "" : readableNumber(value, 4)) }, ...lines],
      hooks: { setScale: [(plot, scale) => { if (scale === "x") this.zoomed(plot); }] },
    }, tables.length > 1 ? uPlot.join(tables) : tables[0], box));
  }

  box(title) {
    const box = document.createElement("section");
    box.innerHTML = `<h3>${escapeHtml(title)}</h3><div></div>`;
    return this.grid.appendChild(box).lastElementChild;
  }

  /// The column that is asked for.
  addAny() {
    const names = Object.keys(this.series[0]).filter((name) => name !== "time" && this.series.every((one) => name in one));
    const box = this.box("").parentElement;
    box.innerHTML = `<h3><label>Column <select>${names.map((name) => `<option${name === this.column ? " selected" : ""}>${escapeHtml(name)}`).join("")}
      </select></label></h3><div></div>`;
    const draw = () => {
      const inner = box.lastElementChild, at = this.plots.findIndex((plot) => inner.contains(plot.root));
      if (at >= 0) this.plots.splice(at, 1)[0].destroy();
      inner.replaceWith(document.createElement("div"));
      const column = (rows) => rows[this.column];
      const place = box.lastElementChild.appendChild(document.createElement("div"));
      this.add("", false, this.runs.map(() => [[this.column, column]]), place.appendChild(document.createElement("div")));
      if (!place.isConnected) box.lastElementChild.innerHTML = "<p class=note>It is zero in all rows.</p>";
    };
    box.querySelector("select").addEventListener("change", (event) => {
      this.column = event.target.value;
      draw();
      this.zoom(...this.range);
    });
    draw();
  }

  /// The same x in all plots.
  zoom(low, high) {
    this.range = [low, high];
    this.quiet = true;
    this.plots.forEach((plot) => plot.setScale("x", { min: low, max: high }));
    queueMicrotask(() => { this.quiet = false; });
    [this.find(".from").value, this.find(".to").value] = [low, high].map((x) => 1000 * this.part(x));
  }

  /// A plot was zoomed by hand: the others follow.
  zoomed(plot) {
    const { min, max } = plot.scales.x;
    if (this.quiet || min === null || (min === this.range?.[0] && max === this.range?.[1])) return;
    this.zoom(min, max);
  }

  part(x) {
    const [low, high] = this.reach;
    return this.logTime ? Math.log(x / low) / Math.log(high / low) : (x - low) / (high - low);
  }

  slide() {
    const [low, high] = this.reach;
    const at = (part) => (this.logTime ? low * (high / low) ** part : low + (high - low) * part);
    let [from, to] = [".from", ".to"].map((name) => Number(this.find(name).value) / 1000);
    if (to - from < 0.01) [from, to] = [Math.min(from, 0.99), Math.min(from, 0.99) + 0.01];
    this.zoom(at(from), at(to));
  }

  fit() {
    for (const plot of this.plots) {
      const width = plot.root.parentElement.clientWidth;
      if (width && width !== plot.width) plot.setSize({ width, height: HEIGHT });
    }
  }
}
