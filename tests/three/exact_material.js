// SPDX-License-Identifier: Apache-2.0
// Makes materials of three.js that average their shading over a grid of points in each pixel. Edges look the same as in
// a single frame. Whatever the textures are, the remaining error comes only from edges.
import { REVISION, ShaderChunk } from "three";
import { fragmentAtPoints } from "/package/shading_points.js";

/** Returns the offset of grid `number`, in samples: a low-discrepancy sequence that starts in the middle. */
export function shiftOfGrid(number) {
  const part = (step) => (0.5 + number * step) % 1 - 0.5;
  // Inverse powers of the plastic number, as in Roberts's R2 sequence.
  return [part(0.7548776662466927), part(0.5698402909980532)];
}

// Contains the package's loop over points, without its term for changing normals.
const PLACES = `
uniform vec2 multum_grid_shift;
void multum_decide() {}
vec4 multum_map(int number, sampler2D map, vec2 st, vec2 along_x, vec2 along_y) {
  return texture2D(map, st, MULTUM_MAP_BIAS);
}
vec2 multum_shift(int evaluation) {
  vec2 place = vec2(evaluation % MULTUM_POINTS.x, evaluation / MULTUM_POINTS.x) + 0.5 + multum_grid_shift;
  return place / vec2(MULTUM_POINTS) - 0.5;
}
`;

/** Makes `material` average `samples` x `samples` points per pixel; its userData.setGrid(number) moves them. */
export function exactMaterial(material, samples) {
  const shift = { value: [0, 0] };
  const defines = { MULTUM_EVALUATIONS: samples ** 2, MULTUM_POINTS: `ivec2(${samples})`,
    MULTUM_MAP_BIAS: (-Math.log2(samples)).toFixed(3) };
  material.onBeforeCompile = (shader) => {
    shader.uniforms.multum_grid_shift = shift;
    shader.fragmentShader = fragmentAtPoints(shader.fragmentShader, ShaderChunk, REVISION, { defines, lobes: PLACES,
      geometry: "" });
  };
  material.customProgramCacheKey = () => `exact ${samples}`;
  material.userData.setGrid = (number) => {
    const [x, down] = shiftOfGrid(number);
    shift.value = [x, -down];
  };
  material.needsUpdate = true;
}
