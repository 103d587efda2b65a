// Robots in 3D: bodies with a nose near by; from afar, where they are a few pixels large, round dots
// that look the same and cost next to nothing, so that a thousand are drawn without a graphics card.

import * as THREE from "three";
import { robotColour } from "./colours.js";

const LEAST_PIXELS = 4.6; // a dot's radius at least

const VERTEX = /* glsl */ `
  attribute vec3 tint;
  attribute vec2 facing;
  varying vec3 vTint;
  varying vec2 vFacing;
  uniform float uSize;
  uniform float uAspect;
  void main() {
    vTint = tint;
    vec4 here = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
    vec4 ahead = projectionMatrix * modelViewMatrix * vec4(position + vec3(facing, 0.0), 1.0);
    vec2 way = (ahead.xy / ahead.w - here.xy / here.w) * vec2(uAspect, 1.0);
    vFacing = length(way) > 0.0 ? normalize(way) : vec2(0.0, 1.0);
    gl_Position = here;
    gl_PointSize = uSize;
  }`;

const FRAGMENT = /* glsl */ `
  precision highp float;
  varying vec3 vTint;
  varying vec2 vFacing;
  void main() {
    vec2 at = (gl_PointCoord - 0.5) * vec2(2.0, -2.0);
    float r = length(at);
    if (r > 1.0) discard;
    // A ball in the light of the scene, with a light nose.
    vec3 normal = vec3(at, sqrt(1.0 - r * r));
    vec3 colour = vTint * (0.55 + 0.55 * max(dot(normal, vec3(-0.35, 0.5, 0.79)), 0.0));
    float along = dot(at, vFacing);
    float beside = abs(dot(at, vec2(-vFacing.y, vFacing.x)));
    if (along > 0.1 && along < 0.92 && beside < 0.2) colour = vec3(1.0, 0.97, 0.9);
    gl_FragColor = vec4(mix(colour, vec3(0.03), smoothstep(0.86, 1.0, r)), 1.0);
    #include <colorspace_fragment>
  }`;

export class Robots {
  /** @param scene where they are drawn. */
  constructor(scene, mission) {
    this.mission = mission;
    const n = mission.robots;
    const body = new THREE.CylinderGeometry(0.92, 1, 0.8, 24).rotateX(Math.PI / 2).translate(0, 0, 0.5);
    const nose = new THREE.BoxGeometry(0.95, 0.34, 0.24).translate(0.62, 0, 0.92);
    this.bodies = new THREE.InstancedMesh(body, new THREE.MeshLambertMaterial(), n);
    this.noses = new THREE.InstancedMesh(nose, new THREE.MeshLambertMaterial({ color: 0xfff7e6 }), n);
    this.noses.instanceMatrix = this.bodies.instanceMatrix;
    this.bodies.setColorAt(0, new THREE.Color());
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * n), 3));
    geometry.setAttribute("tint", new THREE.BufferAttribute(new Float32Array(3 * n), 3));
    geometry.setAttribute("facing", new THREE.BufferAttribute(new Float32Array(2 * n), 2));
    const uniforms = { uSize: { value: 8 }, uAspect: { value: 1 } };
    const material = new THREE.ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms });
    this.dots = new THREE.Points(geometry, material);
    for (const thing of [this.bodies, this.noses, this.dots]) thing.frustumCulled = false;
    this.matrix = new THREE.Matrix4();
    scene.add(this.bodies, this.noses, this.dots);
  }

  /**
   * Put the robots where they are.
   *
   * @param pixelsPerMetre at the middle of what is looked at.
   * @param ratio pixels of the canvas per pixel of the page; @param aspect width by height.
   */
  place(robots, look, pixelsPerMetre, ratio, aspect) {
    const radius = this.mission.facts.radius_m;
    const near = radius * pixelsPerMetre > LEAST_PIXELS;
    this.bodies.visible = this.noses.visible = near;
    this.dots.visible = !near;
    this.dots.material.uniforms.uSize.value = 2 * LEAST_PIXELS * ratio;
    this.dots.material.uniforms.uAspect.value = aspect;
    const { position, tint, facing } = this.dots.geometry.attributes;
    const colour = new THREE.Color();
    for (const robot of robots) {
      const i = robot.robot;
      const z = this.mission.groundAt(robot.x, robot.y);
      const [c, s] = [Math.cos(robot.heading), Math.sin(robot.heading)];
      colour.set(robotColour(robot, look.theme, look.byTeam, look.dark));
      if (near) {
        this.#stand(robot.x, robot.y, z, c, s, radius);
        this.bodies.setMatrixAt(i, this.matrix);
        this.bodies.setColorAt(i, colour);
      } else {
        position.setXYZ(i, robot.x, robot.y, z + 0.3);
        tint.setXYZ(i, colour.r, colour.g, colour.b);
        facing.setXY(i, c, s);
      }
    }
    for (const changed of near ? [this.bodies.instanceMatrix, this.bodies.instanceColor] : [position, tint, facing]) {
      changed.needsUpdate = true;
    }
  }

  /** The matrix of a body that stands on the floor as it slopes there, ahead along (c, s). */
  #stand(x, y, z, c, s, radius) {
    const [riseX, riseY] = this.mission.riseAt(x, y);
    const up = new THREE.Vector3(-riseX, -riseY, 1).normalize();
    const ahead = new THREE.Vector3(c, s, riseX * c + riseY * s).normalize();
    const left = new THREE.Vector3().crossVectors(up, ahead);
    this.matrix.makeBasis(ahead, left, up).scale(new THREE.Vector3(radius, radius, radius));
    this.matrix.setPosition(x, y, z);
  }

  /** Where robots are drawn, in metres. */
  shown() {
    const { array } = this.dots.visible ? this.dots.geometry.attributes.position : this.bodies.instanceMatrix;
    const [stride, first] = this.dots.visible ? [3, 0] : [16, 12];
    return Array.from({ length: this.mission.robots }, (_, i) => [array[stride * i + first], array[stride * i + first + 1]]);
  }
}
