// SPDX-License-Identifier: Apache-2.0
// A surface of points with normals, drawn as small discs that lie in it: thirty thousand of them are one call.

import {BufferAttribute, BufferGeometry, Color, Points, ShaderMaterial} from 'three';

const vertexShader = `
uniform float radius;      // of a disc [m]
uniform float pixels;      // that 1 m has at a distance of 1 m
varying vec3 facing;       // the normal, where z is the way to the eye
varying float eye;
varying float light;
void main() {
  vec4 centre = modelViewMatrix * vec4(position, 1.0);
  vec3 n = normalize(normalMatrix * normal);
  vec3 to_eye = normalize(-centre.xyz);
  facing = vec3(n.xy, dot(n, to_eye));
  eye = centre.z;
  light = 0.5 + 0.12 * dot(n, vec3(0.0, 1.0, 0.0)) + 0.52 * max(0.0, dot(n, normalize(vec3(-0.4, 0.7, 0.6))));
  gl_PointSize = max(2.0 * radius * pixels / -centre.z, 1.5);
  // What looks away is left out.
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  if (facing.z <= 0.0) return;
  gl_Position = projectionMatrix * centre;
}`;

const fragmentShader = `
uniform float radius;
uniform mat4 projectionMatrix;
uniform vec3 color;
uniform float opacity;
varying vec3 facing;
varying float eye;
varying float light;
void main() {
  vec2 d = vec2(2.0, -2.0) * (gl_PointCoord - 0.5);
  float rise = -dot(facing.xy, d) / max(facing.z, 0.05);  // of the disc's plane, towards the eye, in radii
  if (dot(d, d) + rise * rise > 1.0) discard;
#ifdef TILTED
  float z = eye + radius * rise;
  gl_FragDepth = 0.5 - 0.5 * (projectionMatrix[2][2] * z + projectionMatrix[3][2]) / z;
#endif
  gl_FragColor = vec4(color * light * (0.86 + 0.14 * facing.z), opacity);
  #include <colorspace_fragment>
}`;

/**
 * `points`, `normals`: three numbers each; `radius` of a disc [m]. With an opacity below 1 only the nearest discs show.
 * `tilted`: their depth is that of their plane, at every pixel; else of their centre, which a processor draws faster.
 */
export class Splats extends Points {
  constructor(points, normals, radius, color, {opacity = 1, tilted = true} = {}) {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(points, 3));
    geometry.setAttribute('normal', new BufferAttribute(normals, 3));
    const uniforms = {
      radius: {value: radius},
      pixels: {value: 1},
      color: {value: new Color(color)},
      opacity: {value: opacity},
    };
    super(geometry, new ShaderMaterial({vertexShader, fragmentShader, uniforms, defines: tilted ? {TILTED: ''} : {}}));
    this.frustumCulled = false;
    this.uniforms = uniforms;
    this.setOpacity(opacity);
    // A first pass that writes the depth alone leaves the nearest discs, so that what is seen through is one layer.
    const depth = this.material.clone();
    depth.uniforms = uniforms;
    depth.colorWrite = false;
    this.depth = new Points(geometry, depth);
    this.depth.frustumCulled = false;
    this.depth.renderOrder = 1;
    this.renderOrder = 2;
    this.depth.visible = opacity < 1;
    this.add(this.depth);
  }

  setOpacity(opacity) {
    this.uniforms.opacity.value = opacity;
    this.material.transparent = opacity < 1;
    this.material.needsUpdate = true;
    if (this.depth) {
      this.depth.visible = opacity < 1;
      this.depth.material.transparent = opacity < 1; // drawn after what is opaque
    }
  }

  setColor(color) {
    this.uniforms.color.value.set(color);
  }

  /** A camera's height in pixels and its angle decide how large a disc is. */
  fit(camera, height_px) {
    this.uniforms.pixels.value = height_px / (2 * Math.tan((camera.fov * Math.PI) / 360));
  }

  dispose() {
    this.geometry.dispose();
    this.material.dispose();
    this.depth.material.dispose();
  }
}

/** Every n-th point, as many as `enough`, and how much larger its disc must be. */
export function thinned(points, normals, enough) {
  const count = points.length / 3;
  const stride = Math.max(1, Math.ceil(count / enough));
  if (stride === 1) return {points, normals, growth: 1};
  const kept = Math.ceil(count / stride);
  const out = {points: new Float32Array(3 * kept), normals: new Float32Array(3 * kept), growth: Math.sqrt(stride)};
  for (let i = 0; i < kept; ++i) {
    out.points.set(points.subarray(3 * i * stride, 3 * i * stride + 3), 3 * i);
    out.normals.set(normals.subarray(3 * i * stride, 3 * i * stride + 3), 3 * i);
  }
  return out;
}

/**
 * Where a ray meets discs: the nearest to the eye, as {distance}, or null. All in the points' frame; `radius` is how
 * far from its point a disc may be met.
 */
export function hitSplats(points, normals, radius, origin, direction) {
  let best = null;
  for (let i = 0; i < points.length; i += 3) {
    const towards = normals[i] * direction.x + normals[i + 1] * direction.y + normals[i + 2] * direction.z;
    if (towards >= 0) continue;
    const x = points[i] - origin.x;
    const y = points[i + 1] - origin.y;
    const z = points[i + 2] - origin.z;
    const distance = (normals[i] * x + normals[i + 1] * y + normals[i + 2] * z) / towards;
    if (distance <= 0 || (best && distance >= best.distance)) continue;
    const off = Math.hypot(distance * direction.x - x, distance * direction.y - y, distance * direction.z - z);
    if (off <= radius) best = {distance};
  }
  return best;
}
