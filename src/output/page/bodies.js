// The bodies of a run in three dimensions: each sphere is a triangle whose shader finds the sphere's surface.
// Triangles are no instances: where the processor draws, each instance costs as much as a call of its own.
// SPDX-License-Identifier: BSD-3-Clause
import * as THREE from "three";
import { OrbitControls } from "orbit";
import { unpack, unpackField, readableLength, readableNumber, readableTime, escapeHtml } from "packed";
import { findSeen } from "seen";
import { gradient, nameColor, paint, paintNames, paintRock, rangeOf } from "colors";

const ABSENT = -(2 ** 31);
const ACROSS = 1024; // bodies in a line of a texture
const FAR = 200; // of the camera, in sizes of what is shown

const vertexShader = `
precision highp float;
precision highp sampler2D;
uniform mat4 modelViewMatrix, projectionMatrix;
uniform float pixel;
uniform int picked;
uniform sampler2D spheres, colors;
uniform vec3 ground;
out vec2 corner;
flat out vec3 center;
flat out float radius;
flat out vec3 lit, dim;  // colour times light, and without
flat out int mark;
void main() {
  int body = gl_VertexID / 3, k = gl_VertexID % 3;
  ivec2 texel = ivec2(body % ${ACROSS}, body / ${ACROSS});
  vec4 sphere = texelFetch(spheres, texel, 0);
  center = (modelViewMatrix * vec4(sphere.xyz, 1.0)).xyz;
  radius = sphere.w > 0.0 ? max(sphere.w, pixel) : 0.0;  // small ones stay to be seen
  corner = k == 0 ? vec2(-1.7320508, -1.0) : k == 1 ? vec2(1.7320508, -1.0) : vec2(0.0, 2.0);  // round the unit circle
  vec3 tint = texelFetch(colors, texel, 0).rgb;
  float fog = 0.4 * smoothstep(0.2, 2.2, ${(-FAR / 2).toFixed(1)} - center.z);
  lit = (1.0 - fog) * tint;
  dim = fog * ground;
  mark = body == picked ? 1 : 0;
  gl_Position = projectionMatrix * vec4(center + vec3(radius * corner, 0.0), 1.0);
}`;

const fragmentShader = `
precision highp float;
uniform mat4 projectionMatrix;
uniform vec4 cut;  // in the camera's frame: what lies above it is taken away
in vec2 corner;
flat in vec3 center;
flat in float radius;
flat in vec3 lit, dim;
flat in int mark;
out vec4 shown;
void main() {
  float square = dot(corner, corner);
  if (square > 1.0) discard;
  vec3 normal = vec3(corner, sqrt(1.0 - square));
  float depth = center.z + radius * normal.z, shade = 1.0;
#ifdef CUT
  float above = dot(cut.xyz, vec3(center.xy + radius * corner, depth)) - cut.w;
  if (above > 0.0) {
    if (cut.z <= 0.0) discard;
    depth -= above / cut.z;
    if (depth < center.z - radius * normal.z) discard;
    normal = cut.xyz;
    shade = 0.8;
  }
#endif
  float light = max(dot(normal, vec3(-0.42, 0.56, 0.71)), 0.0);
  vec3 seen = lit * (shade * (0.42 + 0.30 * normal.z + 0.42 * light)) + dim;
  if (mark == 1) seen = square > 0.7 ? vec3(1.0) : mix(seen, vec3(1.0, 0.55, 0.1), 0.75);
  shown = vec4(seen, 1.0);
  gl_FragDepth = 0.5 + 0.5 * (projectionMatrix[2][2] * depth + projectionMatrix[3][2]);
}`;

const controls = (id) => `
  <div class=stage>
    <canvas id=${id} tabindex=0 role=application aria-label="Bodies in three dimensions. Arrow keys turn, plus and minus zoom."></canvas>
    <div class=overlay><span class=scale></span><svg class=axes viewBox="-30 -30 60 60" aria-hidden=true></svg></div>
  </div>
  <div class=legend></div>
  <div class=controls>
    <div class=time><button class=play type=button aria-label="Play through time">▶</button>
      <label><span class=hidden>Instant</span><input class=slider type=range min=0 step=1></label>
      <output class=instant></output></div>
    <label>Colour <select class=field></select></label>
    <label class=check><input class=log type=checkbox> logarithmic</label>
    <label>Cut <select class=cut><option value="">none<option value=0>across x<option value=1>across y<option value=2>across z
      <option value=view>facing the viewer</select></label>
    <label class=depth hidden>at <input class=level type=range min=-1 max=1 step=0.01 value=0></label>
    <label>Body <input class=body type=number min=0 placeholder="number"></label>
    <button class=home type=button>Whole view</button>
    <label class="check follow"><input class=keep type=checkbox> follow the middle</label>
  </div>
  <div class=picked role=status aria-live=polite></div>`;

export class View {
  constructor(element, run, number) {
    this.run = run;
    this.header = run.bodies;
    this.frames = [];
    this.at = 0;
    this.picked = -1;
    element.innerHTML = controls(`bodies_${number}`);
    this.find = (name) => element.querySelector(name);
    this.canvas = this.find("canvas");
    this.make();
    this.listen(element);
  }

  make() {
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: false, powerPreference: "high-performance" });
    this.scene = new THREE.Scene();
    this.camera = new THREE.OrthographicCamera(-1, 1, 1, -1, 0, FAR);
    this.camera.up.set(0, 0, 1);
    const count = this.header.count, lines = Math.ceil(count / ACROSS);
    this.spheres = new Float32Array(4 * ACROSS * lines);
    this.colors = new Uint8Array(4 * ACROSS * lines);
    this.textures = [new THREE.DataTexture(this.spheres, ACROSS, lines, THREE.RGBAFormat, THREE.FloatType),
      new THREE.DataTexture(this.colors, ACROSS, lines)];
    const geometry = new THREE.BufferGeometry();
    this.list = new THREE.BufferAttribute(new Uint32Array(3 * count), 1);
    geometry.setIndex(this.list);
    this.geometry = geometry;
    this.uniforms = { spheres: { value: this.textures[0] }, colors: { value: this.textures[1] }, pixel: { value: 0 },
      picked: { value: -1 }, cut: { value: new THREE.Vector4(0, 0, 0, 1) }, ground: { value: new THREE.Color() } };
    this.shader = new THREE.RawShaderMaterial({ vertexShader, fragmentShader, uniforms: this.uniforms,
      glslVersion: THREE.GLSL3 });
    const mesh = new THREE.Mesh(geometry, this.shader);
    mesh.frustumCulled = false;
    this.scene.add(mesh);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.zoomToCursor = true;
    this.controls.minZoom = 0.02;
    this.controls.maxZoom = 500;
    this.ratio = window.devicePixelRatio;
  }

  listen(element) {
    const on = (name, event, act) => this.find(name).addEventListener(event, act);
    this.controls.addEventListener("change", () => { this.draw(); this.onTurn?.(this); });
    new ResizeObserver(() => this.resize()).observe(this.canvas.parentElement);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
    on(".slider", "input", (event) => this.show(Number(event.target.value)));
    on(".play", "click", () => this.play());
    on(".field", "change", () => this.color());
    on(".log", "change", () => this.color(this.find(".log").checked));
    on(".cut", "change", (event) => {
      this.find(".depth").hidden = !event.target.value;
      this.shader.defines = event.target.value ? { CUT: "" } : {};
      this.shader.needsUpdate = true;
      this.draw();
    });
    on(".level", "input", () => this.draw());
    on(".home", "click", () => this.home());
    on(".keep", "change", () => this.show(this.at));
    on(".body", "input", (event) => this.pick(event.target.value === "" ? -1 : this.ids.indexOf(Number(event.target.value))));
    on("canvas", "keydown", (event) => this.key(event));
    let down = null;
    on("canvas", "pointerdown", (event) => { down = [event.clientX, event.clientY]; });
    on("canvas", "pointerup", (event) => {
      if (down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 5) this.pickAt(event);
      down = null;
    });
  }

  /// Unpacks what is fixed and the frames that the page carries.
  async load(frames) {
    const fixed = this.header.fixed;
    [this.radius, this.mass, this.ids, this.group, this.material] = await Promise.all([
      unpack(fixed.radius, Float32Array), unpack(fixed.mass, Float32Array), unpack(fixed.id, Int32Array),
      unpack(fixed.group, Int32Array), unpack(fixed.material, Int32Array)]);
    const options = ["One colour", "group", "material", "radius, m",
      ...this.header.fields.map(({ label, unit }) => (unit ? `${label}, ${unit}` : label))];
    this.find(".field").innerHTML = options.map((name, k) => `<option value=${k}>${escapeHtml(name)}`).join("");
    const speed = this.header.fields.findIndex(({ label }) => label === "speed");
    this.find(".field").value = speed < 0 ? 1 : 4 + speed;
    for (const frame of frames) await this.add(frame);
    this.settle();
  }

  /// Unpacks one more frame. Frames stay in order of time; who looks at the last one sees the new one.
  async add(frame) {
    const position = await unpack(frame.position, Int32Array);
    const fields = await Promise.all(frame.fields.map(unpackField));
    const wasLast = this.at >= this.frames.length - 1;
    this.frames.push({ number: frame.number, time: frame.time, middle: frame.middle, position, fields });
    this.frames.sort((a, b) => a.number - b.number);
    if (wasLast) this.at = this.frames.length - 1;
  }

  /// Drops frames that are no longer among those to be shown.
  keep(numbers) {
    this.frames = this.frames.filter((frame) => numbers.includes(frame.number));
  }

  /// After frames came or went: the size of what is shown, the slider, the colours.
  settle() {
    if (!this.frames.length) return;
    if (!this.size) {
      this.measure();
      this.home();
    }
    this.find(".slider").max = this.frames.length - 1;
    this.at = Math.min(this.at, this.frames.length - 1);
    this.color();
    this.show(this.at);
  }

  /// A middle and a size that hold nearly all bodies at first: those far away do not count.
  measure() {
    const { position, middle } = this.frames[0];
    const distances = [];
    for (let k = 0; k < this.header.count; ++k) {
      if (position[3 * k] === ABSENT) continue;
      const [x, y, z] = [0, 1, 2].map((c) => position[3 * k + c] - middle[c]);
      distances.push(Math.hypot(x, y, z) * this.header.step + this.radius[k]);
    }
    distances.sort((a, b) => a - b);
    this.size = distances[Math.floor(0.98 * (distances.length - 1))];
    this.cell = (0.45 * this.radius.toSorted()[Math.floor(this.radius.length / 2)]) / this.size;
    this.middle = middle;
    const moved = Math.hypot(...this.frames.at(-1).middle.map((at, c) => at - middle[c])) * this.header.step;
    this.find(".keep").checked = moved > this.size;
    this.find(".follow").hidden = moved < 0.05 * this.size;
  }

  home() {
    this.camera.position.set(-0.42, -0.82, 0.39).multiplyScalar(FAR / 2);
    this.camera.zoom = 0.82;
    this.controls.target.set(0, 0, 0);
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.draw();
  }

  show(at) {
    const frame = this.frames[at];
    if (!frame) return;
    this.at = at;
    const middle = this.find(".keep").checked ? frame.middle : this.middle, scale = this.header.step / this.size;
    for (let k = 0; k < this.header.count; ++k) {
      const there = frame.position[3 * k] !== ABSENT;
      for (let c = 0; c < 3; ++c) this.spheres[4 * k + c] = there ? (frame.position[3 * k + c] - middle[c]) * scale : 0;
      this.spheres[4 * k + 3] = there ? this.radius[k] / this.size : 0;
    }
    this.textures[0].needsUpdate = true;
    const { impact } = this.run, after = impact !== null && frame.time > impact;
    const text = after ? `${readableTime(frame.time - impact)} after the impact` : readableTime(frame.time);
    const slider = this.find(".slider");
    slider.value = at;
    slider.setAttribute("aria-valuetext", text);
    this.find(".instant").textContent = `${text}, ${at + 1} of ${this.frames.length}`;
    this.paint();
    this.tell();
  }

  /// Values of the field that is chosen, in a frame.
  values(choice, frame) {
    if (choice === 3) return this.radius;
    return frame.fields[choice - 4];
  }

  /// The colours' range is that of all frames, so that colours mean the same through time.
  color(log) {
    const choice = Number(this.find(".field").value), isValue = choice > 2;
    if (isValue) {
      const key = `${choice} ${this.frames.length}`;
      if (this.rangeKey !== key) this.range = rangeOf(choice === 3 ? [this.radius] : this.frames.map((frame) => this.values(choice, frame)));
      this.rangeKey = key;
      if (log !== undefined) this.range = { ...this.range, log: log && this.range.high > 0, low: log && this.range.low <= 0 ? this.range.high * 1e-6 : this.range.low };
      this.find(".log").checked = this.range.log;
    }
    this.find(".log").parentElement.hidden = !isValue;
    this.legend(choice);
    this.paint();
  }

  legend(choice) {
    const name = escapeHtml(this.find(".field").selectedOptions[0]?.textContent ?? "");
    const names = choice === 1 ? this.header.names.group : choice === 2 ? this.header.names.material : null;
    let text = "";
    if (names) text = names.map((one, k) => `<span class=swatch><i style="background:${nameColor(k)}"></i>${escapeHtml(one)}</span>`).join("");
    else if (choice > 2)
      text = `<span>${readableNumber(this.range.low)}</span><i class=bar style="background:${gradient}"></i>
        <span>${readableNumber(this.range.high)}</span><span class=note>${name}${this.range.log ? ", logarithmic" : ""}</span>`;
    this.find(".legend").innerHTML = text;
  }

  paint() {
    const choice = Number(this.find(".field").value), frame = this.frames[this.at];
    if (!frame) return;
    if (choice === 0) paintRock(this.colors, this.header.count);
    else if (choice < 3) paintNames(this.colors, choice === 1 ? this.group : this.material);
    else paint(this.colors, this.values(choice, frame), this.range);
    this.textures[1].needsUpdate = true;
    this.draw();
  }

  play() {
    const stop = this.playing !== undefined, button = this.find(".play");
    clearInterval(this.playing);
    this.playing = undefined;
    button.textContent = stop ? "▶" : "❚❚";
    button.setAttribute("aria-label", stop ? "Play through time" : "Pause");
    if (stop) return;
    if (this.at === this.frames.length - 1) this.show(0);
    const pause = Math.max(60, Math.min(700, 6000 / this.frames.length));
    this.playing = setInterval(() => (this.at + 1 < this.frames.length ? this.show(this.at + 1) : this.play()), pause);
  }

  key(event) {
    const turn = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
    const zoom = { "+": 1.15, "=": 1.15, "-": 1 / 1.15 }[event.key];
    if (turn) this.turn(...turn);
    else if (zoom) {
      this.camera.zoom *= zoom;
      this.camera.updateProjectionMatrix();
      this.draw();
      this.onTurn?.(this);
    } else if (event.key === "Escape") this.pick(-1);
    else return;
    event.preventDefault();
  }

  /// Around the vertical axis and up or down, in radians.
  turn(around, up) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const place = new THREE.Spherical().setFromVector3(new THREE.Vector3(offset.x, offset.z, -offset.y));
    place.theta += around;
    place.phi = Math.min(Math.PI - 0.01, Math.max(0.01, place.phi + up));
    const at = new THREE.Vector3().setFromSpherical(place);
    this.camera.position.set(at.x, -at.z, at.y).add(this.controls.target);
    this.controls.update();
  }

  /// The same direction and zoom as another view.
  turnLike(other) {
    this.camera.position.copy(other.camera.position);
    this.camera.zoom = other.camera.zoom;
    this.controls.target.copy(other.controls.target);
    this.camera.lookAt(this.controls.target);
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  /// The nearest body under a place of the canvas.
  pickAt(event) {
    const box = this.canvas.getBoundingClientRect();
    const x = (2 * (event.clientX - box.left)) / box.width - 1, y = 1 - (2 * (event.clientY - box.top)) / box.height;
    const e = this.camera.matrixWorldInverse.elements, p = this.camera.projectionMatrix.elements, cut = this.cutNow();
    let best = -1, nearest = -Infinity;
    for (let k = 0; k < this.header.count; ++k) {
      const [sx, sy, sz, radius] = this.spheres.subarray(4 * k, 4 * k + 4);
      if (!(radius > 0)) continue;
      const at = [0, 1, 2].map((c) => e[c] * sx + e[4 + c] * sy + e[8 + c] * sz + e[12 + c]);
      const r = Math.max(radius, 2 * this.uniforms.pixel.value);
      const [dx, dy] = [(x - p[12]) / p[0] - at[0], (y - p[13]) / p[5] - at[1]];
      const height = r * r - dx * dx - dy * dy;
      if (height < 0) continue;
      let depth = at[2] + Math.sqrt(height);
      const above = cut.x * (at[0] + dx) + cut.y * (at[1] + dy) + cut.z * depth - cut.w;
      if (above > 0) {
        if (cut.z <= 0) continue;
        depth -= above / cut.z;
        if (depth < at[2] - Math.sqrt(height)) continue;
      }
      if (depth > nearest) [best, nearest] = [k, depth];
    }
    this.find(".body").value = best < 0 ? "" : this.ids[best];
    this.pick(best);
  }

  pick(row) {
    this.picked = row;
    this.uniforms.picked.value = row;
    this.tell();
    this.draw();
  }

  /// What is known of the body that is picked.
  tell() {
    const k = this.picked, frame = this.frames[this.at], box = this.find(".picked");
    if (k < 0 || !frame) { box.innerHTML = ""; return; }
    const { names, fields, low, step } = this.header;
    const at = [0, 1, 2].map((c) => frame.position[3 * k + c]);
    const place = at[0] === ABSENT ? "not there yet" : at.map((value, c) => readableNumber(low[c] + value * step, 5)).join(", ");
    const facts = [["body", this.ids[k]], ["group", names.group[this.group[k]]], ["material", names.material[this.material[k]]],
      ["radius", `${readableNumber(this.radius[k], 4)} m`],
      ["mass", Number.isFinite(this.mass[k]) ? `${readableNumber(this.mass[k], 4)} kg` : "held: fixed or prescribed"],
      ["place, m", place], ...fields.map(({ label, unit }, f) => [label, `${readableNumber(frame.fields[f][k])} ${unit}`])];
    box.innerHTML = `<dl>${facts.map(([name, value]) => `<div><dt>${escapeHtml(name)}<dd>${escapeHtml(value ?? "")}</div>`).join("")}</dl>`;
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (!width || !height) return;
    this.aspect = width / height;
    const half = this.aspect < 1 ? 1 / this.aspect : 1;
    Object.assign(this.camera, { left: -half * this.aspect, right: half * this.aspect, top: half, bottom: -half });
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  /// The plane of the cut in the camera's frame.
  cutNow() {
    const choice = this.find(".cut").value, level = Number(this.find(".level").value);
    if (choice === "") return new THREE.Vector4(0, 0, 0, 1);
    if (choice === "view") return new THREE.Vector4(0, 0, 1, -FAR / 2 - level);
    const normal = new THREE.Vector3().setComponent(Number(choice), 1);
    const toward = this.camera.position.clone().sub(this.controls.target);
    const point = normal.clone().multiplyScalar(level).applyMatrix4(this.camera.matrixWorldInverse);
    if (normal.dot(toward) < 0) normal.negate(); // the half that hides the face goes
    const turned = normal.transformDirection(this.camera.matrixWorldInverse);
    return new THREE.Vector4(turned.x, turned.y, turned.z, turned.dot(point));
  }

  /// Asks for a picture; several wishes make one.
  draw() {
    this.wanted ??= requestAnimationFrame((now) => {
      this.wanted = undefined;
      this.drawNow(now);
    });
  }

  /// While pictures follow each other too slowly they are made of fewer pixels; the last one is whole.
  drawNow(now) {
    if (!this.aspect || !this.size) return;
    const pause = now - (this.last ?? 0), full = window.devicePixelRatio;
    this.last = now;
    if (pause > 34 && pause < 400) this.ratio = Math.max(0.4, 0.85 * this.ratio);
    else if (pause < 20) this.ratio = Math.min(full, 1.02 * this.ratio);
    clearTimeout(this.whole);
    if (this.ratio < full) this.whole = setTimeout(() => this.render(full), 250);
    this.render(this.ratio);
  }

  render(ratio) {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    if (ratio !== this.renderer.getPixelRatio()) this.renderer.setPixelRatio(ratio);
    const before = this.renderer.getSize(new THREE.Vector2());
    if (before.x !== width || before.y !== height) this.renderer.setSize(width, height, false);
    const ground = getComputedStyle(this.canvas.parentElement).backgroundColor;
    this.renderer.setClearColor(ground);
    this.uniforms.ground.value.setStyle(ground, THREE.LinearSRGBColorSpace);
    this.camera.updateMatrixWorld();
    this.uniforms.cut.value.copy(this.cutNow());
    const wide = (this.camera.right - this.camera.left) / this.camera.zoom;
    this.uniforms.pixel.value = wide / width;
    this.choose();
    this.renderer.render(this.scene, this.camera);
    this.overlay(wide, width);
  }

  /// Only what may be seen is drawn.
  choose() {
    const { left, right, top, bottom, zoom, matrixWorldInverse } = this.camera, isCut = this.find(".cut").value !== "";
    const box = { left: left / zoom, bottom: bottom / zoom, width: (right - left) / zoom, height: (top - bottom) / zoom };
    const count = findSeen(this.list.array, this.spheres, this.header.count, matrixWorldInverse.elements, box,
      this.uniforms.pixel.value, this.cell, isCut ? this.uniforms.cut.value : null);
    this.list.needsUpdate = true;
    this.geometry.setDrawRange(0, 3 * count);
  }

  /// The scale and the directions of the axes.
  overlay(wide, width) {
    const wanted = (wide * this.size) / 5, power = 10 ** Math.floor(Math.log10(wanted));
    const length = power * [5, 2, 1].find((factor) => factor * power <= wanted);
    const scale = this.find(".scale");
    scale.style.width = `${(length / (wide * this.size)) * width}px`;
    scale.textContent = readableLength(length);
    const e = this.camera.matrixWorldInverse.elements;
    this.find(".axes").innerHTML = [0, 1, 2].map((c) => {
      const [x, y] = [20 * e[4 * c], -20 * e[4 * c + 1]];
      return `<line x2=${x} y2=${y} /><text x=${1.35 * x} y=${1.35 * y}>${"xyz"[c]}</text>`;
    }).join("");
  }
}
