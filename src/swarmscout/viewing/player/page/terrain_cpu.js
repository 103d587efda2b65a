// The cave for machines without a graphics card: its surface is drawn when the camera moves and kept; as long as the
// camera stands still, only the light of what is known is drawn anew. Drawing the surface's triangles is most of a
// frame there, and scrubbing through a mission does not move the camera.

import * as THREE from "three";
import { LIGHT } from "./terrain.js";

const VERTEX = /* glsl */ `
  void main() {
    gl_Position = vec4(position.xy, 0.0, 1.0);
  }`;

const FRAGMENT = /* glsl */ `
  precision highp float;
  ${LIGHT}
  uniform sampler2D uLit, uDarkness, uAt, uDepth;
  void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec4 dark = texelFetch(uDarkness, here, 0);
    if (dark.a == 0.0) discard;
    vec4 lit = texelFetch(uLit, here, 0);
    vec4 at = texelFetch(uAt, here, 0);
    vec2 place = (floor(at.xy * 255.0 + 0.5) + at.zw) / 255.0;
    gl_FragColor = vec4(lighted(lit.rgb * lit.rgb, dark.rgb * dark.rgb, lit.a, place), 1.0);
    gl_FragDepth = texelFetch(uDepth, here, 0).r; // What stands behind a wall stays there.
    #include <colorspace_fragment>
  }`;

export class StillTerrain {
  /** @param terrain what is drawn; @param scene where its picture is shown instead of it. */
  constructor(terrain, scene) {
    this.terrain = terrain;
    terrain.mesh.visible = false;
    this.surface = new THREE.Scene();
    const mesh = new THREE.Mesh(terrain.mesh.geometry, terrain.stillMaterial);
    mesh.frustumCulled = false;
    this.surface.add(mesh);
    this.target = new THREE.WebGLRenderTarget(1, 1, {
      count: 3, minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter,
      depthTexture: new THREE.DepthTexture(1, 1, THREE.UnsignedIntType),
    });
    const [lit, dark, at] = this.target.textures;
    const uniforms = {
      ...terrain.uniforms,
      uLit: { value: lit }, uDarkness: { value: dark }, uAt: { value: at }, uDepth: { value: this.target.depthTexture },
    };
    const material = new THREE.ShaderMaterial({
      vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms, depthFunc: THREE.AlwaysDepth,
    });
    this.picture = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material);
    this.picture.frustumCulled = false;
    this.picture.renderOrder = -1;
    scene.add(this.picture);
    this.kept = "";
    this.size = new THREE.Vector2();
  }

  /** Draw the surface again if anything but the light has changed since. Returns whether that was so. */
  refresh(renderer, camera) {
    renderer.getDrawingBufferSize(this.size);
    const { x, y } = this.size;
    camera.updateMatrixWorld();
    const { theme, isCoarse } = this.terrain;
    const kept = [x, y, theme.background, isCoarse, camera.projectionMatrix.elements, camera.matrixWorld.elements].join();
    if (kept === this.kept) return false;
    this.kept = kept;
    this.target.setSize(x, y);
    renderer.setRenderTarget(this.target);
    renderer.setClearColor(0, 0);
    renderer.clear();
    renderer.render(this.surface, camera);
    renderer.setRenderTarget(null);
    return true;
  }
}
