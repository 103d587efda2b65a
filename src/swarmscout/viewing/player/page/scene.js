// The cave in 3D with its robots, and a sheet over it for what is drawn in lines.

import * as THREE from "three";
import { OrbitControls } from "./vendor/OrbitControls.js";
import { Sheet } from "./canvas.js";
import { drawCompass, drawScale } from "./gauges.js";
import { drawOverlay } from "./overlay.js";
import { Robots } from "./robots.js";
import { StillTerrain } from "./terrain_cpu.js";
import { Terrain } from "./terrain.js";

const SLOW_MS = 60; // a frame that takes longer is not fluent

/** What this browser draws 3D with: "none", "processor" or "card". */
export function drawsWith() {
  try {
    const gl = document.createElement("canvas").getContext("webgl2");
    if (!gl) return "none";
    let name = gl.getParameter(gl.RENDERER);
    // Some browsers say it by the plain name, others by this extension only.
    if (name === "WebKit WebGL") {
      const info = gl.getExtension("WEBGL_debug_renderer_info");
      if (info) name = gl.getParameter(info.UNMASKED_RENDERER_WEBGL);
    }
    gl.getExtension("WEBGL_lose_context")?.loseContext();
    return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name) ? "processor" : "card";
  } catch {
    return "none";
  }
}

export class SceneView {
  /**
   * @param box the element to fill, with two canvases; @param changed called when it wants to be drawn again.
   * @param slowly whether a processor does the work of a graphics card: spare what costs most from the start.
   */
  constructor(box, mission, changed, slowly = false) {
    this.box = box;
    this.mission = mission;
    this.changed = changed;
    const [canvas, sheet] = box.querySelectorAll("canvas");
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !slowly, powerPreference: "high-performance" });
    this.ratio = Math.min(window.devicePixelRatio || 1, 2);
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color();
    this.camera = new THREE.PerspectiveCamera(38, 1, 0.5, 3000);
    this.camera.up.set(0, 0, 1);
    this.terrain = new Terrain(mission);
    this.scene.add(this.terrain.mesh);
    this.still = slowly ? new StillTerrain(this.terrain, this.scene) : null;
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8a7f70, 2.2));
    const sun = new THREE.DirectionalLight(0xffffff, 1.4);
    sun.position.set(-4, 3, 8);
    this.scene.add(sun);
    this.robots = new Robots(this.scene, mission);
    this.sheet = new Sheet(sheet, () => this.#resize());
    this.controls = new OrbitControls(this.camera, sheet);
    Object.assign(this.controls, {
      enableDamping: false, zoomToCursor: true, maxPolarAngle: 1.45, screenSpacePanning: false,
      minDistance: 2, maxDistance: 900, zoomSpeed: 1.2,
    });
    this.controls.addEventListener("change", () => {
      this.touched = true;
      this.box.dispatchEvent(new Event("moved"));
      changed();
    });
    this.touched = false;
    this.slow = 0;
    this.window = mission.seenWindow();
    this.#resize();
  }

  #resize() {
    this.renderer.setPixelRatio(this.ratio);
    this.renderer.setSize(this.sheet.width, this.sheet.height, false);
    this.camera.aspect = this.sheet.width / this.sheet.height;
    this.camera.updateProjectionMatrix();
    if (!this.touched && this.controls) this.fit(this.window);
    this.changed();
  }

  /** Look at a window in metres from the south, so that north is up as on the map. */
  fit(window) {
    this.window = window;
    const [left, bottom, right, top] = window;
    const [x, y] = [(left + right) / 2, (bottom + top) / 2];
    const [across, away] = [right - left, top - bottom];
    const tilt = 0.98; // radians above the horizon
    const half = Math.tan((this.camera.fov * Math.PI) / 360);
    const forWidth = (0.54 * across) / (half * this.camera.aspect) + 0.5 * away * Math.cos(tilt);
    const forDepth = (0.54 * away * Math.sin(tilt)) / half + 0.5 * away * Math.cos(tilt);
    const distance = Math.max(12, forWidth, forDepth);
    const z = this.mission.groundAt(x, y);
    this.controls.target.set(x, y, z);
    this.camera.position.set(x, y - distance * Math.cos(tilt), z + distance * Math.sin(tilt));
    this.controls.update();
    this.touched = false;
    this.changed();
  }

  /** Move the camera so that it keeps looking at a point. */
  follow(x, y) {
    const target = new THREE.Vector3(x, y, this.mission.groundAt(x, y));
    const shift = target.clone().sub(this.controls.target);
    if (shift.length() < 0.004) return;
    this.controls.target.copy(target);
    this.camera.position.add(shift);
    const distance = this.camera.position.distanceTo(target);
    if (!this.following && distance > 30) {
      this.camera.position.sub(target).multiplyScalar(30 / distance).add(target);
    }
    this.following = true;
    this.touched = true;
    this.camera.lookAt(target);
  }

  /** Take another view's camera, so that two missions look alike. */
  copyCamera(other) {
    this.camera.position.copy(other.camera.position);
    this.controls.target.copy(other.controls.target);
    this.camera.lookAt(this.controls.target);
    this.touched = true;
  }

  /** Metres that a pixel spans at a point. */
  #metresPerPixel(x, y, z) {
    const distance = this.camera.position.distanceTo(new THREE.Vector3(x, y, z));
    return (2 * distance * Math.tan((this.camera.fov * Math.PI) / 360)) / this.sheet.height;
  }

  toPixels(x, y, level = [x, y]) {
    const p = new THREE.Vector3(x, y, this.mission.groundAt(...level) + 0.12).project(this.camera);
    if (p.z > 1) return null;
    return [((p.x + 1) / 2) * this.sheet.width, ((1 - p.y) / 2) * this.sheet.height];
  }

  /** The point of the floor under a pixel, or null: a few steps along the ray onto the relief. */
  toMetres(px, py) {
    const ray = new THREE.Raycaster();
    ray.setFromCamera(
      new THREE.Vector2((2 * px) / this.sheet.width - 1, 1 - (2 * py) / this.sheet.height), this.camera,
    );
    const { origin, direction } = ray.ray;
    if (direction.z >= -0.01) return null;
    let z = this.controls.target.z;
    let point = null;
    for (let i = 0; i < 6; i++) {
      const far = (z - origin.z) / direction.z;
      point = [origin.x + far * direction.x, origin.y + far * direction.y];
      z = this.mission.groundAt(...point);
    }
    return point;
  }

  draw(moment, look) {
    this.terrain.dress(look.theme);
    this.terrain.paint();
    this.scene.background.set(look.theme.background);
    const { x, y, z } = this.controls.target;
    const scale = 1 / this.#metresPerPixel(x, y, z);
    this.robots.place(moment.robots, look, scale, this.ratio, this.camera.aspect);
    this.camera.updateMatrixWorld();
    this.redrawn = this.still?.refresh(this.renderer, this.camera) ?? true;
    this.renderer.render(this.scene, this.camera);
    const ctx = this.sheet.begin();
    const view = {
      at: (x, y, level) => this.toPixels(x, y, level),
      scale: (x, y) => 1 / this.#metresPerPixel(x, y, this.mission.groundAt(x, y)),
    };
    drawOverlay(ctx, view, moment, { ...look, dots: false });
    drawScale(ctx, this.sheet, scale, look.theme, " at the centre");
    const ahead = this.controls.target.clone().sub(this.camera.position).normalize();
    const level = Math.hypot(ahead.x, ahead.y) || 1;
    const [fx, fy] = [ahead.x / level, ahead.y / level];
    const flat = -ahead.z; // a level circle is seen this much flatter
    drawCompass(ctx, this.sheet, look.theme, [fy, fx * flat], [-fx, fy * flat]);
  }

  /**
   * On a machine without a graphics card a picture of the rock that is kept while the camera stands still, and, where
   * that is not enough, coarser rock and fewer pixels keep it fluent.
   */
  keepPace(ms) {
    this.slow = ms > SLOW_MS && ms < 1000 ? this.slow + 1 : 0; // A page in the background waits for long.
    if (this.slow < 3) return;
    this.slow = 0;
    if (!this.still) this.still = new StillTerrain(this.terrain, this.scene);
    else if (!this.terrain.isCoarse && this.redrawn) this.terrain.coarsen();
    else if (this.ratio > 0.7) {
      this.ratio = Math.max(0.7, this.ratio * 0.75);
      this.#resize();
    }
  }

  /** Where the robots are drawn, in metres; for tests. */
  shownPositions() {
    return this.robots.shown();
  }
}
