// The cave as a cut-away model: floor and the lower part of the walls, lit where the swarm has been.

import * as THREE from "three";

const RIM_M = 2.2;

const VERTEX = /* glsl */ `
  attribute vec4 shade; // open share, light from above, height, nearness to the floor
  varying vec4 vShade;
  varying vec3 vNormal;
  varying vec2 vMap;
  uniform vec4 uFrame; // x, y, width, height of the map in metres
  void main() {
    vShade = shade;
    vNormal = normal;
    vMap = (position.xy - uFrame.xy) / uFrame.zw;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }`;

/** A point's colour where it is known, where it is not, and how far the floor's signs show on it. */
const SURFACE = /* glsl */ `
  precision highp float;
  varying vec4 vShade;
  varying vec3 vNormal;
  varying vec2 vMap;
  uniform vec3 uLow, uHigh, uRock, uCut, uBackground, uGlow;
  uniform float uDark;
  void surface(out vec3 lit, out vec3 dark, out float floorShare) {
    float rock = 1.0 - smoothstep(0.2, 0.8, vShade.x);
    float top = smoothstep(0.9, 1.0, rock);
    vec3 normal = normalize(vNormal);
    float sun = max(dot(normal, normalize(vec3(-0.45, 0.35, 0.82))), 0.0);
    vec3 stone = mix(mix(uLow, uHigh, vShade.z), uRock, rock * 0.85);
    lit = stone * (0.34 + 0.86 * sun) * mix(0.62, 1.0, vShade.y);
    float gray = dot(stone, vec3(0.3, 0.5, 0.2)) * (0.55 + 0.45 * sun) * mix(0.7, 1.0, vShade.y);
    dark = mix(uCut * 0.92, vec3(gray) * vec3(0.86, 0.94, 1.06), 0.35) * uDark;
    // The cut through the rock is flat and plain; its lip catches some light where it is known.
    float near = smoothstep(0.0, 0.75, vShade.w);
    lit = mix(uBackground, mix(lit, uCut + 0.10 * uGlow, top), near);
    dark = mix(uBackground, mix(dark, uCut, top), near);
    floorShare = (1.0 - rock) * (1.0 - top) * near;
  }`;

/** What the map knows puts light on a surface. */
export const LIGHT = /* glsl */ `
  uniform sampler2D uMapTexture; // red: known, green: frontier, blue: seen just now
  uniform vec3 uFrontier, uGlow;
  vec3 lighted(vec3 lit, vec3 dark, float floorShare, vec2 at) {
    vec3 seen = texture2D(uMapTexture, at).rgb;
    float known = smoothstep(0.25, 0.75, seen.r);
    vec3 colour = mix(dark, lit, known);
    colour = mix(colour, uFrontier, smoothstep(0.3, 0.9, seen.g) * 0.38 * floorShare);
    return colour + uGlow * seen.b * 0.16 * known * floorShare;
  }`;

const FRAGMENT = /* glsl */ `
  ${SURFACE}
  ${LIGHT.replace(", uGlow", "")}
  void main() {
    vec3 lit, dark;
    float floorShare;
    surface(lit, dark, floorShare);
    gl_FragColor = vec4(lighted(lit, dark, floorShare, vMap), 1.0);
    #include <colorspace_fragment>
  }`;

/** The same surface without light, into three pictures; roots of colours, for eight bits are few in the dark. */
const STILL_FRAGMENT = /* glsl */ `
  ${SURFACE}
  layout(location = 0) out vec4 outLit;
  layout(location = 1) out vec4 outDark;
  layout(location = 2) out vec4 outAt;
  void main() {
    vec3 lit, dark;
    float floorShare;
    surface(lit, dark, floorShare);
    outLit = vec4(sqrt(lit), floorShare);
    outDark = vec4(sqrt(dark), 1.0);
    vec2 at = clamp(vMap, 0.0, 1.0) * 255.0;
    outAt = vec4(floor(at) / 255.0, fract(at));
  }`;

const GLOW = "#ffdf9e"; // what was seen just now
const UNSEEN = 0.62; // brightness of what is not mapped

/** Colours of a theme for the shaders. */
function coloursOf(theme) {
  return {
    uLow: theme.ground_low, uHigh: theme.ground_high, uRock: theme.rock, uCut: theme.cut,
    uBackground: theme.background, uFrontier: theme.frontier, uGlow: GLOW,
  };
}

/** The model of a mission's cave: a mesh, and a texture that says what is known. */
export class Terrain {
  constructor(mission) {
    this.mission = mission;
    const { rows, columns, x_m: x, y_m: y, cell_m: cell } = mission.frame;
    this.pixels = new Uint8Array(rows * columns * 4);
    this.texture = new THREE.DataTexture(this.pixels, columns, rows, THREE.RGBAFormat);
    this.texture.magFilter = this.texture.minFilter = THREE.LinearFilter;
    this.frontier = new Uint8Array(rows * columns);
    this.painted = {}; // which map, after which step
    this.uniforms = {
      uMapTexture: { value: this.texture },
      uFrame: { value: new THREE.Vector4(x, y, columns * cell, rows * cell) },
      ...Object.fromEntries(Object.keys(coloursOf({})).map((name) => [name, { value: new THREE.Color() }])),
      uDark: { value: UNSEEN },
    };
    const both = { vertexShader: VERTEX, uniforms: this.uniforms };
    this.material = new THREE.ShaderMaterial({ ...both, fragmentShader: FRAGMENT });
    this.stillMaterial = new THREE.ShaderMaterial({
      ...both, fragmentShader: STILL_FRAGMENT, glslVersion: THREE.GLSL3,
    });
    const { geometry, number } = geometryOf(mission.relief);
    this.number = number;
    this.isCoarse = false;
    geometry.setIndex(trianglesOf(mission.relief, number, 1));
    this.mesh = new THREE.Mesh(geometry, this.material);
    this.mesh.frustumCulled = false;
  }

  dress(theme) {
    if (this.theme === theme) return;
    this.theme = theme;
    for (const [name, value] of Object.entries(coloursOf(theme))) this.uniforms[name].value.set(value);
  }

  /** Light what the map at the step of `mission.seek` knows. */
  paint() {
    const { pixels } = this;
    const map = this.mission.shownMap;
    if (this.painted.map === map && this.painted.step === map.step) return;
    this.painted = { map, step: map.step };
    map.frontiers(this.frontier);
    for (let cell = 0; cell < map.labels.length; cell++) {
      const known = map.labels[cell] !== 0;
      const age = map.step - map.knownSince[cell];
      pixels[4 * cell] = known ? 255 : 0;
      pixels[4 * cell + 1] = this.frontier[cell] ? 255 : 0;
      pixels[4 * cell + 2] = known && age < 12 && age >= 0 ? 255 - 21 * age : 0;
    }
    this.texture.needsUpdate = true;
  }

  /** Draw a quarter of the triangles. */
  coarsen() {
    this.isCoarse = true;
    this.mesh.geometry.setIndex(trianglesOf(this.mission.relief, this.number, 2));
  }
}

/** Vertices on the relief's grid wherever there is something to show. */
function geometryOf(relief) {
  const { rows, columns, cell_m: cell, wall_m: wall } = relief;
  const share = Float32Array.from(relief.share, (value) => (value ? (value - 1) / 254 : 0));
  const light = blurred(share, rows, columns, Math.max(1, Math.round(0.9 / cell)));
  const away = distances(share, rows, columns, cell);
  const height = new Float32Array(rows * columns);
  let [low, high] = [Infinity, -Infinity];
  for (let i = 0; i < height.length; i++) {
    if (!relief.share[i]) continue;
    const t = Math.min(1, Math.max(0, (share[i] - 0.2) / 0.6));
    height[i] = relief.ground[i] + wall * (1 - t * t * (3 - 2 * t));
    if (share[i] > 0.8) [low, high] = [Math.min(low, relief.ground[i]), Math.max(high, relief.ground[i])];
  }
  const number = new Int32Array(rows * columns).fill(-1);
  const places = [];
  for (let i = 0; i < number.length; i++) {
    if (!relief.share[i]) continue;
    number[i] = places.length;
    places.push(i);
  }
  const position = new Float32Array(places.length * 3);
  const normal = new Int8Array(places.length * 3);
  const shade = new Uint8Array(places.length * 4);
  const at = (row, col, otherwise) => {
    const i = Math.min(rows - 1, Math.max(0, row)) * columns + Math.min(columns - 1, Math.max(0, col));
    return relief.share[i] ? height[i] : otherwise;
  };
  places.forEach((i, k) => {
    const row = Math.floor(i / columns);
    const col = i - row * columns;
    position.set([relief.x_m + (col + 0.5) * cell, relief.y_m + (row + 0.5) * cell, height[i]], 3 * k);
    const dx = (at(row, col - 1, height[i]) - at(row, col + 1, height[i])) / (2 * cell);
    const dy = (at(row - 1, col, height[i]) - at(row + 1, col, height[i])) / (2 * cell);
    const length = Math.hypot(dx, dy, 1);
    normal.set([(127 * dx) / length, (127 * dy) / length, 127 / length], 3 * k);
    const level = high > low + 0.05 ? Math.min(1, Math.max(0, (relief.ground[i] - low) / (high - low))) : 0.8;
    const near = 1 - Math.min(1, away[i] / RIM_M);
    shade.set([255 * share[i], 255 * Math.min(1, light[i] * 1.15), 255 * level, 255 * near], 4 * k);
  });
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(position, 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(normal, 3, true));
  geometry.setAttribute("shade", new THREE.BufferAttribute(shade, 4, true));
  return { geometry, number };
}

/** Two triangles for each square of the grid, or of every second point of it, that is shown. */
function trianglesOf({ rows, columns }, number, stride) {
  const triangles = [];
  for (let row = 0; row + stride < rows; row += stride) {
    for (let col = 0; col + stride < columns; col += stride) {
      const i = row * columns + col;
      const j = i + stride * columns;
      const [a, b, c, d] = [number[i], number[i + stride], number[j], number[j + stride]];
      if (a >= 0 && b >= 0 && c >= 0 && d >= 0) triangles.push(a, b, d, a, d, c);
    }
  }
  return new THREE.BufferAttribute(new Uint32Array(triangles), 1);
}

/** Means over squares of (2 · reach + 1)² cells. */
function blurred(values, rows, columns, reach) {
  let result = values;
  for (const [count, length, step, stride] of [[rows, columns, columns, 1], [columns, rows, 1, columns]]) {
    const next = new Float32Array(values.length);
    for (let lane = 0; lane < count; lane++) {
      let sum = 0;
      for (let i = -reach; i < length; i++) {
        if (i + reach < length) sum += result[lane * step + (i + reach) * stride];
        if (i - reach - 1 >= 0) sum -= result[lane * step + (i - reach - 1) * stride];
        if (i >= 0) next[lane * step + i * stride] = sum / (2 * reach + 1);
      }
    }
    result = next;
  }
  return result;
}

/** Distance of each cell to the floor in metres, to a few percent (two sweeps). */
function distances(share, rows, columns, cell) {
  const far = new Float32Array(share.length);
  for (let i = 0; i < far.length; i++) far[i] = share[i] > 0.3 ? 0 : 1e6;
  const relax = (i, j, d) => {
    if (far[j] + d < far[i]) far[i] = far[j] + d;
  };
  const slant = cell * Math.SQRT2;
  for (const way of [1, -1]) {
    for (let n = 0; n < far.length; n++) {
      const i = way > 0 ? n : far.length - 1 - n;
      const col = i % columns;
      const row = (i - col) / columns;
      const back = way > 0 ? row > 0 : row < rows - 1;
      if (way > 0 ? col > 0 : col < columns - 1) relax(i, i - way, cell);
      if (!back) continue;
      relax(i, i - way * columns, cell);
      if (col > 0) relax(i, i - way * columns - 1, slant);
      if (col < columns - 1) relax(i, i - way * columns + 1, slant);
    }
  }
  return far;
}
