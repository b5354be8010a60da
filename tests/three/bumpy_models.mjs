// SPDX-License-Identifier: Apache-2.0
// Writes models that do not need a licence: four bumpy surfaces, each on a sphere and on a plane, and four small models
// like those that artists make. The bytes are the same each time, except where a Node.js release changes sines or
// deflate.
//
//   node bumpy_models.mjs OUT [TEXELS]
import { writeFileSync } from "node:fs";
import path from "node:path";
import { argv } from "node:process";
import { pathToFileURL } from "node:url";
import { makeGlb } from "./glb_writer.mjs";

/** Uniform in [0, 1), by mulberry32. */
function randomFrom(seed) {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  };
}

const wrapped = (i, n) => ((i % n) + n) % n;
const smooth = (t) => { const x = Math.min(1, Math.max(0, t)); return x * x * (3 - 2 * x); };

/** Returns heights from `at(x, y)`, with coordinates in [0, 1), in units of the map's width. */
function heights(n, at) {
  const made = new Float64Array(n * n);
  for (let y = 0; y < n; ++y) for (let x = 0; x < n; ++x) made[y * n + x] = at((x + 0.5) / n, (y + 0.5) / n, x, y);
  return made;
}

/** Returns periodic noise of standard deviation 1: white noise blurred three times by boxes of `width` texels. */
function noise(n, width, random) {
  let from = Float64Array.from({ length: n * n }, () => random() - 0.5);
  const reach = Math.max(1, Math.round(width)) >> 1;
  for (let pass = 0; pass < 6; ++pass) {
    const to = new Float64Array(n * n), [across, along] = pass % 2 ? [1, n] : [n, 1];
    for (let line = 0; line < n; ++line) {
      let sum = 0;
      for (let i = -reach; i <= reach; ++i) sum += from[line * across + wrapped(i, n) * along];
      for (let i = 0; i < n; ++i) {
        to[line * across + i * along] = sum;
        const at = (place) => from[line * across + wrapped(place, n) * along];
        sum += at(i + reach + 1) - at(i - reach);
      }
    }
    from = to;
  }
  const deviation = Math.sqrt(from.reduce((sum, value) => sum + value * value, 0) / (n * n));
  return from.map((value) => value / deviation);
}

/** Returns slopes (dh/du, dh/dv) of heights, v downwards; a texel's normal is (-dh/du, dh/dv, 1). */
function slopesOf(height, n) {
  return (x, y) => [(height[y * n + wrapped(x + 1, n)] - height[y * n + wrapped(x - 1, n)]) * n / 2,
    (height[wrapped(y + 1, n) * n + x] - height[wrapped(y - 1, n) * n + x]) * n / 2];
}

const byte = (value) => Math.round(255 * Math.min(1, Math.max(0, value)));
const normalBytes = (x, y, z) => [x, y, z].map((value) => byte(0.5 + 0.5 * value / Math.hypot(x, y, z)));
const image = (n, at) => {
  const rgb = new Uint8Array(3 * n * n);
  for (let y = 0; y < n; ++y) for (let x = 0; x < n; ++x) rgb.set(at(x, y), 3 * (y * n + x));
  return { width: n, height: n, rgb };
};
const normalMapOf = (height, n) => {
  const slopes = slopesOf(height, n);
  return image(n, (x, y) => { const [u, v] = slopes(x, y); return normalBytes(-u, v, 1); });
};

/** Hammer dents: the lowest of round bowls. */
function hammered(n) {
  const random = randomFrom(5), height = new Float64Array(n * n);
  for (let dent = 0; dent < 900; ++dent) {
    const [px, py, r] = [random() * n, random() * n, (0.02 + 0.025 * random()) * n];
    for (let y = Math.floor(py - r); y <= py + r; ++y)
      for (let x = Math.floor(px - r); x <= px + r; ++x) {
        const at = wrapped(y, n) * n + wrapped(x, n), inside = 1 - ((x - px) ** 2 + (y - py) ** 2) / r ** 2;
        if (inside > 0) height[at] = Math.min(height[at], -inside * r / n * 0.35);
      }
  }
  return { normal: normalMapOf(height, n), color: [0.9, 0.85, 0.8], metalness: 1, roughness: 0.25 };
}

/** Flakes of car paint: cells of eight texels, each with its own tilt. */
function flakes(n) {
  const random = randomFrom(7), cells = Math.round(n / 8), size = n / cells;
  const flake = Array.from({ length: cells * cells }, () => {
    const tilt = Math.min(1.2, -0.22 * Math.log(1 - random())), turn = 2 * Math.PI * random();
    return { x: random(), y: random(),
      bytes: normalBytes(Math.sin(tilt) * Math.cos(turn), Math.sin(tilt) * Math.sin(turn), Math.cos(tilt)) };
  });
  const normal = image(n, (x, y) => {
    let [best, nearest] = [null, Infinity];
    const [cx, cy] = [Math.floor(x / size), Math.floor(y / size)];
    for (let j = cy - 1; j <= cy + 1; ++j)
      for (let i = cx - 1; i <= cx + 1; ++i) {
        const one = flake[wrapped(j, cells) * cells + wrapped(i, cells)];
        const away = (x + 0.5 - (i + one.x) * size) ** 2 + (y + 0.5 - (j + one.y) * size) ** 2;
        if (away < nearest) [best, nearest] = [one, away];
      }
    return best.bytes;
  });
  return { normal, color: [0.1, 0.2, 0.7], metalness: 0.8, roughness: 0.25 };
}

/** Wet bricks, each slightly tilted, and mortar between them. */
function bricks(n) {
  const random = randomFrom(11), rows = 16, columns = 8, rough = noise(n, n / 128, random);
  const tilts = Array.from({ length: rows * columns }, () => [random() - 0.5, random() - 0.5]);
  const height = heights(n, (u, v, x, y) => {
    const row = Math.floor(v * rows), along = u * columns + 0.5 * (row % 2), column = Math.floor(along) % columns;
    const [fx, fy] = [along % 1, (v * rows) % 1], [tu, tv] = tilts[row * columns + column];
    const edge = Math.min((0.5 - Math.abs(fx - 0.5)) * 2 / columns, (0.5 - Math.abs(fy - 0.5)) * 2 / rows);
    return 0.008 * smooth(edge / 0.012) + 0.1 * (tu * (fx - 0.5) / columns + tv * (fy - 0.5) / rows) +
      0.0004 * rough[y * n + x];
  });
  return { normal: normalMapOf(height, n), color: [0.4, 0.15, 0.1], metalness: 0, roughness: 0.2 };
}

/** Water in a breeze: waves with whole numbers of periods. */
function water(n) {
  const random = randomFrom(13);
  const waves = Array.from({ length: 40 }, () => {
    const angle = (random() - 0.5) * 2.2, length = 3 * 1.085 ** (40 * random());
    const [fu, fv] = [Math.round(length * Math.cos(angle)), Math.round(length * Math.sin(angle))];
    return { fu, fv, phase: 2 * Math.PI * random(), rise: 0.011 / Math.max(1, Math.hypot(fu, fv)) };
  });
  const height = heights(n, (u, v) => waves.reduce((sum, one) =>
    sum + one.rise * Math.sin(2 * Math.PI * (one.fu * u + one.fv * v) + one.phase), 0));
  return { normal: normalMapOf(height, n), color: [0.02, 0.06, 0.08], metalness: 0, roughness: 0.08 };
}

/** Makes a grid of columns x rows quads: `at(u, v)` gives { position, normal }; maps repeat `repeat` times. */
function mesh(columns, rows, repeat, at) {
  const made = { positions: [], normals: [], uvs: [], indices: [] };
  for (let j = 0; j <= rows; ++j)
    for (let i = 0; i <= columns; ++i) {
      const { position, normal } = at(i / columns, j / rows);
      made.positions.push(...position);
      made.normals.push(...normal);
      made.uvs.push(i / columns * repeat[0], j / rows * repeat[1]);
    }
  for (let j = 0; j < rows; ++j)
    for (let i = 0; i < columns; ++i) {
      const a = j * (columns + 1) + i, b = a + columns + 1;
      made.indices.push(a, b, b + 1, a, b + 1, a + 1);
    }
  return made;
}

/** Makes a sphere around the origin, with maps that repeat 2 * `repeat` times around it. */
export const sphere = (radius, repeat) => mesh(128, 64, [2 * repeat, repeat], (u, v) => {
  const [turn, fall] = [2 * Math.PI * u, Math.PI * v];
  const normal = [Math.sin(fall) * Math.cos(turn), Math.cos(fall), -Math.sin(fall) * Math.sin(turn)];
  return { position: normal.map((value) => radius * value), normal };
});
/** Makes a plane with sides of `side` metres, seen at 60 degrees from its normal. */
const plane = (side, repeat) => mesh(1, 1, [repeat, repeat], (u, v) => ({
  position: [side * (u - 0.5), side * 0.5 * (0.5 - v), side * 0.866 * (v - 0.5)], normal: [0, 0.866, 0.5] }));

const SIDES = 10;
/** Flat staves on a mesh of few sides with interpolated normals: the map turns these normals back. */
function barrel(n) {
  const random = randomFrom(17), grain = slopesOf(noise(n, n / 100, random).map((value) => 0.0006 * value), n);
  const at = (x, y) => {
    const stave = (x + 0.5) / n * SIDES, across = stave % 1 - 0.5, turn = across * 2 * Math.PI / SIDES;
    const edge = Math.max(0, Math.abs(across) - 0.42) / 0.08, [u, v] = grain(x, y);
    return { edge, turn: -turn + Math.sign(across) * 0.6 * edge, slopes: [u * 0.3, v], hoop: (y / n * 4) % 1 > 0.85 };
  };
  return { normal: image(n, (x, y) => {
    const { turn, slopes: [u, v], hoop } = at(x, y), grained = hoop ? 0.2 : 1;
    return normalBytes(Math.sin(turn) - u * grained, v * grained, Math.cos(turn));
  }), colors: image(n, (x, y) => {
    const { edge, hoop } = at(x, y), dim = 1 - 0.6 * Math.min(1, edge);
    return (hoop ? [150, 150, 155] : [150, 95, 50]).map((value) => value * dim);
  }), surface: image(n, (x, y) => (at(x, y).hoop ? [0, 90, 230] : [0, 150, 0])),
  mesh: mesh(SIDES, 4, [1, 1], (u, v) => {
    const turn = 2 * Math.PI * u, radius = 0.55 - 0.6 * (v - 0.5) ** 2;
    return { position: [radius * Math.cos(turn), 0.7 - 1.4 * v, -radius * Math.sin(turn)],
      normal: [Math.cos(turn), 0, -Math.sin(turn)] };
  }) };
}

/** Metal spheres that exist only in the map. */
function domes(n) {
  const count = 6;
  return { normal: image(n, (x, y) => {
    const inDome = (place) => (((place + 0.5) / n * count) % 1 * 2 - 1) / 0.9, [u, v] = [inDome(x), -inDome(y)];
    const square = u * u + v * v;
    return square < 1 ? normalBytes(u, v, Math.sqrt(1 - square)) : normalBytes(0, 0, 1);
  }), color: [0.9, 0.8, 0.6], metalness: 1, roughness: 0.35,
  mesh: mesh(1, 1, [1, 1], (u, v) => ({ position: [2 * u - 1, 1 - 2 * v, 0], normal: [0, 0, 1] })) };
}

/** Rough stones of several colours on four walls. */
function tower(n) {
  const random = randomFrom(19), rough = noise(n, n / 60, random), rows = 12, columns = 6;
  const shades = Array.from({ length: rows * columns }, () => 0.5 + 0.5 * random());
  const stone = (u, v) => {
    const row = Math.floor(v * rows), along = u * columns + 0.5 * (row % 2), column = Math.floor(along) % columns;
    const edge = Math.min((0.5 - Math.abs(along % 1 - 0.5)) / columns, (0.5 - Math.abs((v * rows) % 1 - 0.5)) / rows);
    return { shade: shades[row * columns + column], inside: smooth(edge / 0.02) };
  };
  const height = heights(n, (u, v, x, y) => 0.015 * stone(u, v).inside + 0.0015 * rough[y * n + x]);
  return { normal: normalMapOf(height, n), colors: image(n, (x, y) => {
    const { shade, inside } = stone((x + 0.5) / n, (y + 0.5) / n), light = shade * (0.35 + 0.65 * inside);
    return [180 * light, 165 * light, 145 * light];
  }), surface: image(n, (x, y) => [0, 205 + 40 * stone((x + 0.5) / n, (y + 0.5) / n).inside, 0]),
  mesh: mesh(4, 1, [4, 3], (u, v) => {
    const turn = 2 * Math.PI * u, side = 0.6 - 0.1 * (1 - v);
    return { position: [side * Math.cos(turn), 1 - 2 * v, -side * Math.sin(turn)],
      normal: [Math.cos(turn), 0, -Math.sin(turn)] };
  }) };
}

/** A quilted cloth cover: dents of its shape over a fine weave. */
function cover(n) {
  const wave = (place) => Math.sin(Math.PI * place);
  const height = heights(n, (u, v) => 0.03 * Math.abs(wave(4 * (u + v)) * wave(4 * (u - v))) +
    0.0008 * wave(96 * u) * wave(96 * v));
  return { normal: normalMapOf(height, n), color: [0.55, 0.1, 0.12], metalness: 0, roughness: 0.55,
    mesh: sphere(0.7, 2) };
}

export const SURFACES = { hammered, flakes, bricks, water }, MODELS = { barrel, domes, tower, cover };

/** Writes NAME_sphere.glb and NAME_plane.glb of the surfaces, with maps of `texels` x `texels`; returns their names. */
export function writeSurfaces(folder, texels) {
  return Object.entries(SURFACES).flatMap(([name, make]) => {
    const surface = make(texels);
    return Object.entries({ sphere: sphere(0.5, 3), plane: plane(1.6, 4) }).map(([shape, one]) => {
      writeFileSync(path.join(folder, `${name}_${shape}.glb`), makeGlb(`${name}_${shape}`, { ...surface, mesh: one }));
      return `${name}_${shape}`;
    });
  });
}

/** Writes NAME.glb of the small models; returns their names. */
export function writeModels(folder, texels) {
  return Object.entries(MODELS).map(([name, make]) => {
    writeFileSync(path.join(folder, `${name}.glb`), makeGlb(name, make(texels)));
    return name;
  });
}

if (import.meta.url === pathToFileURL(argv[1] ?? "").href) {
  const texels = Number(argv[3] ?? 1024);
  for (const name of [...writeSurfaces(argv[2], texels), ...writeModels(argv[2], texels)]) console.log(`${name}.glb`);
}
