// SPDX-License-Identifier: Apache-2.0
// Tests @multum/three in headless Chromium. Compares pictures with the pictures of multum-view and with supersampled
// pictures of three.js. Also tests every kind of light, shadows, fog, environments, instances, skins, shared materials,
// disposal, and refusals. Exits with 77 (skipped) if something is missing.
//
//   node addon_test.mjs BIN_FOLDER PICTURES
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import os from "node:os";
import path from "node:path";
import { executablePath, openPage } from "./addon_browser.mjs";

const [bin, pictures] = process.argv.slice(2);
const skip = (why) => { console.log(`skipped: ${why}`); process.exit(77); };
if (executablePath === undefined) skip("no Chromium (Debian package chromium-headless-shell)");
if (!existsSync(path.join(bin, "multum-view"))) skip("no multum-view was built");
const { chromium } = await import("../service/web/node_modules/playwright-core/index.mjs").catch(() =>
  skip("no playwright-core: tools/install_dependencies test"));

const folder = mkdtempSync(path.join(os.tmpdir(), "multum-three-"));
const inFolder = (name) => path.join(folder, name);
const run = (program, ...words) => execFileSync(path.join(bin, program), words, { cwd: folder, encoding: "utf8",
  stdio: ["ignore", "pipe", "pipe"] });
mkdirSync(pictures, { recursive: true });
const [WIDTH, HEIGHT] = [240, 180];

/** Runs `act(page, argument)` in the page, where `lab` has the functions of addon_page.js. */
const inPage = (page, act, argument) => page.evaluate(act, argument);

/** Compares with one evaluation per lobe: multum-view's points follow the pixel's longer axis, three.js's are 2 x 2. */
async function besideMultumView(page) {
  const views = await inPage(page, () => globalThis.lab.VIEWS);
  for (const [view, [eye, target]] of Object.entries(views))
    for (const file of view === "far" ? ["map.ktx2", "halves.ktx2"] : ["map.ktx2"]) {
      run("multum-view", file, "--source", "map_normal.png", "--size", `${WIDTH}x${HEIGHT}`, "--brdf", "ggx:0.3",
        "--diffuse", "0.1", "--specular", "1", "--light", "0.3,0.8,0.5", "--camera", [...eye, ...target, 40].join(","),
        "--evaluations", "0", "-o", "view.png");
      const found = await inPage(page, async ([view, file, width, height]) => {
        const { lab } = globalThis, fine = await lab.loadNormals(), lobes = await lab.loadLobes(file);
        fine.minFilter = lab.THREE.LinearFilter;
        fine.generateMipmaps = false;
        const draw = (map, more, samples) => {
          const material = lab.surface(map);
          if (more) lab.addLobes(material, more);
          const scene = lab.sceneOf(material, lab.directional([0.3, 0.8, 0.5]));
          return lab.drawn(scene, lab.cameraAt(...lab.VIEWS[view], width / height), width, height, samples);
        };
        const reference = draw(fine, null, 8), pixels = draw(await lab.loadNormals(), lobes, 1);
        const png = await lab.png(pixels, width, height);
        const off = async (url) => (await lab.beside(reference, width, height, url)).mean;
        return { png, own: await off(`data:image/png;base64,${png}`), view: await off("/files/view.png") };
      }, [view, file, WIDTH, HEIGHT]);
      writeFileSync(path.join(pictures, `${view}_${path.parse(file).name}.png`), Buffer.from(found.png, "base64"));
      console.log(`  ${view}, ${file}: ${found.own.toFixed(2)} of 255 off, multum-view ${found.view.toFixed(2)}`);
      assert.ok(found.own <= found.view, `${view}, ${file}: ${found.own} of 255 off, multum-view ${found.view}`);
    }
}

/** All formats of one file draw alike, whether the processor or the GPU decodes them. */
async function formatsAgree(page) {
  const found = await inPage(page, async () => {
    const { lab } = globalThis;
    const normals = await lab.loadNormals(), pictures = {}, bytes = {};
    const draw = (material) => lab.drawn(lab.sceneOf(material, lab.directional([0.3, 0.8, 0.5])),
      lab.cameraAt(...lab.VIEWS.far, 1), 128, 128);
    for (const [name, file, blocks] of [["blocks", "map.ktx2", true], ["decoded", "map.ktx2", false],
      ["zstd", "zstd.ktx2", true], ["rgba8", "rgba8.ktx2", true], ["halves", "halves.ktx2", true]]) {
      const material = lab.surface(normals), lobes = await lab.loadLobes(file, blocks);
      bytes[name] = lobes.byteCount;
      lab.addLobes(material, lobes);
      pictures[name] = draw(material);
    }
    pictures.plain = draw(lab.surface(normals));
    const errors = Object.fromEntries(Object.entries(pictures).map(([name, one]) =>
      [name, lab.compared(one, pictures.halves).error]));
    return { bytes, errors, unpacked: lab.compared(pictures.zstd, pictures.blocks).error,
      decoded: lab.compared(pictures.decoded, pictures.blocks).error };
  });
  console.log("  formats:", JSON.stringify(found));
  const { bytes, errors } = found;
  assert.equal(found.unpacked, 0);
  // The values of blocks are rounded to 8 bits.
  assert.ok(found.decoded < 0.1, `decoded blocks differ by ${found.decoded}`);
  for (const name of ["blocks", "decoded", "rgba8"])
    assert.ok(errors[name] > 0 && errors[name] < 0.1, `${name}: ${errors[name]}`);
  assert.ok(errors.plain > 5 * errors.blocks, "lobes draw the same as plain mips");
  assert.deepEqual([bytes.decoded, bytes.rgba8], [bytes.rgba8, bytes.halves / 2]);
  assert.ok(bytes.blocks < 0.51 * bytes.rgba8 && bytes.zstd === bytes.blocks);
}

/** Compares three.js's lights with each other: a distant light of any kind equals a directional light. */
async function lightsAgree(page) {
  const found = await inPage(page, async () => {
    const { lab } = globalThis, { THREE } = lab;
    const normals = await lab.loadNormals(), lobes = await lab.loadLobes("halves.ktx2");
    const camera = lab.cameraAt(...lab.VIEWS.steep, 1), direction = [0.3, 0.8, 0.5];
    const draw = (objects, options, changed = () => {}) => {
      const material = lab.surface(normals, options);
      lab.addLobes(material, lobes);
      const scene = lab.sceneOf(material, ...objects);
      changed(scene, material);
      return lab.drawn(scene, camera, 120, 120);
    };
    const far = (light) => {
      const reach = 5000;
      light.intensity = Math.PI * reach ** 2 * (0.3 ** 2 + 0.8 ** 2 + 0.5 ** 2);
      light.position.set(...direction.map((one) => one * reach));
      return light;
    };
    const sun = draw([lab.directional(direction)]);
    const spot = far(new THREE.SpotLight(0xffffff, 1, 0, 0.5));
    const result = {
      tangents: lab.compared(draw([lab.directional(direction)], { hasTangents: true }), sun),
      point: lab.compared(draw([far(new THREE.PointLight())]), sun),
      spot: lab.compared(draw([spot, spot.target]), sun),
      dark: lab.compared(draw([]), sun).energy,
      both: lab.compared(draw([lab.directional(direction), lab.directional(direction)]), sun).energy,
    };
    const shadowed = (casts) => {
      const light = lab.directional(direction);
      light.castShadow = casts;
      Object.assign(light.shadow.camera, { left: -3, right: 3, top: 3, bottom: -3, near: 0.1, far: 20 });
      light.position.multiplyScalar(5);
      const box = new THREE.Mesh(new THREE.BoxGeometry(0.4, 0.4, 0.4), new THREE.MeshBasicMaterial());
      box.position.set(0.3, 1.9, 0.5);
      box.castShadow = true;
      return draw([light, box]);
    };
    const [lit, shaded] = [shadowed(false), shadowed(true)];
    // Each pixel is unchanged or darker, and at least a tenth of the pixels get no light.
    let [brighter, black, changed] = [0, 0, 0];
    for (let i = 0; i < lit.length; i += 4) {
      if (shaded[i] > lit[i] + 1e-5) ++brighter;
      if (Math.abs(shaded[i] - lit[i]) > 1e-5) ++changed;
      if (shaded[i] === 0 && lit[i] > 0) ++black;
    }
    result.shadow = { brighter, black, changed, pixels: lit.length / 4 };
    const fogged = draw([lab.directional(direction)], {}, (scene) =>
      { scene.fog = new THREE.Fog(0x00ff00, 0.5, 1.5); });
    result.fog = [fogged, sun].map((one) => one.reduce((sum, value, i) => sum + (i % 4 === 1 ? value : 0), 0) / 14400);
    const area = new THREE.RectAreaLight(0xffffff, 20, 1, 1);
    area.position.set(0.3, 1.5, 1);
    area.lookAt(0, 1, 0);
    const { RectAreaLightUniformsLib } = await import("three/addons/lights/RectAreaLightUniformsLib.js");
    RectAreaLightUniformsLib.init();
    result.area = lab.compared(draw([area]), sun).energy;
    const sky = new THREE.HemisphereLight(0xffffff, 0x000000, Math.PI);
    sky.position.set(0, 0, 1);
    result.sky = lab.compared(draw([sky]), sun).energy;
    return result;
  });
  console.log("  lights:", JSON.stringify(found));
  for (const name of ["tangents", "point", "spot"])
    assert.ok(found[name].error < 2e-3, `${name}: ${found[name].error}`);
  assert.equal(found.dark, 0);
  assert.ok(Math.abs(found.both - 2) < 1e-4);
  assert.equal(found.shadow.brighter, 0);
  assert.ok(found.shadow.black > 200 && found.shadow.changed < 0.9 * found.shadow.pixels, JSON.stringify(found.shadow));
  assert.ok(found.fog[0] > found.fog[1] + 0.05, "fog adds no green");
  assert.ok(found.area > 0.01 && found.sky > 0.01, "an area light or a hemisphere light has no effect");
}

/**
 * README.md's table: for each light, the highest error of lobes and the lowest errors of points and plain mips, in %.
 */
function statedErrors() {
  const text = readFileSync(inFolder("shaders/three/README.md"), "utf8");
  const rows = text.matchAll(/^\| (.*) \| (\d+) % \| (\d+) % \| (\d+) % \|$/gm);
  return Object.fromEntries(Array.from(rows, ([, name, ...numbers]) => [name, numbers.map(Number)]));
}

/** Compares lobes with three.js's own supersampled shading of one normal and one roughness. */
async function besideSupersampled(page) {
  const found = await inPage(page, async () => {
    const { lab } = globalThis, { THREE } = lab;
    const lobes = await lab.loadLobes("map.ktx2"), [width, height] = [64, 48];
    const camera = lab.cameraAt(...lab.VIEWS.far, width / height);
    const { RoomEnvironment } = await import("three/addons/environments/RoomEnvironment.js");
    const pmrem = new THREE.PMREMGenerator(lab.renderer);
    const room = pmrem.fromScene(new RoomEnvironment(), 0.01).texture;
    const fine = await lab.loadNormals();
    fine.minFilter = THREE.LinearFilter;
    fine.generateMipmaps = false;
    const mipped = await lab.loadNormals();
    const sky = () => {
      const light = new THREE.HemisphereLight(0xffffff, 0x203040, Math.PI);
      light.position.set(0, 0.6, 0.8);
      return light;
    };
    const area = () => {
      const light = new THREE.RectAreaLight(0xffffff, 30, 4, 4);
      light.position.set(1, 8, 3);
      light.lookAt(0.5, 5, 0);
      return light;
    };
    const result = {};
    for (const [name, lit, options] of [["directional", (scene) => scene.add(lab.directional([0.3, 0.8, 0.5])), {}],
      ["directional, rough", (scene) => scene.add(lab.directional([0.3, 0.8, 0.5])), { roughness: 0.6 }],
      ["environment", (scene) => { scene.environment = room; }, {}],
      ["environment, metal", (scene) => { scene.environment = room; }, { metalness: 1 }],
      ["environment, rough metal", (scene) => { scene.environment = room; }, { metalness: 1, roughness: 0.6 }],
      ["hemisphere", (scene) => scene.add(sky()), {}], ["area light, metal", (scene) => scene.add(area()),
        { metalness: 1 }]]) {
      const draw = (map, samples, more) => {
        const material = lab.surface(map, options);
        material.color.setScalar(0.6);
        if (more === lobes) lab.addLobes(material, more);
        if (more === "points") lab.addPoints(material, { evaluations: 16 });
        const scene = lab.sceneOf(material);
        lit(scene);
        return lab.drawn(scene, camera, width, height, samples);
      };
      const reference = draw(fine, 12);
      const [plain, points, ours] = [draw(mipped, 1), draw(mipped, 1, "points"), draw(mipped, 1, lobes)].map((one) =>
        lab.compared(one, reference));
      result[name] = { plain, points, lobes: ours };
    }
    return result;
  });
  const stated = statedErrors();
  assert.deepEqual(Object.keys(stated), Object.keys(found), "the rows of README.md's table differ");
  const percent = (share) => `${(100 * share).toFixed(1)} %`;
  for (const [name, { plain, points, lobes }] of Object.entries(found)) {
    console.log(`  ${name}: error ${percent(lobes.error)}, energy ${lobes.energy.toFixed(3)}; plain mips ` +
      `${percent(plain.error)}, ${plain.energy.toFixed(3)}; 16 points ${percent(points.error)}`);
    const [most, pointsLeast, plainLeast] = stated[name];
    assert.ok(100 * lobes.error <= most, `${name}: ${percent(lobes.error)}, README.md says ${most} %`);
    assert.ok(100 * points.error >= pointsLeast && points.error < plain.error,
      `${name}, points: ${percent(points.error)}, README.md says ${pointsLeast} %`);
    assert.ok(100 * plain.error >= plainLeast, `${name}: ${percent(plain.error)}, README.md says ${plainLeast} %`);
    assert.ok(Math.abs(lobes.energy - 1) < 0.1, `${name}: energy ${lobes.energy}`);
  }
}

/** Instances, skins, clearcoat and similar features compile and draw the right picture. */
async function geometriesAndLayers(page) {
  const found = await inPage(page, async () => {
    const { lab } = globalThis, { THREE } = lab;
    const normals = await lab.loadNormals(), lobes = await lab.loadLobes("map.ktx2");
    const camera = lab.cameraAt([0, -3, 0.5], [0, 0, 0], 1), light = () => lab.directional([0.2, -0.6, 0.6]);
    const material = (options) => {
      const made = lab.surface(normals, options);
      lab.addLobes(made, lobes);
      return made;
    };
    const draw = (...objects) => {
      const scene = new THREE.Scene();
      scene.add(light(), ...objects);
      return lab.drawn(scene, camera, 96, 96);
    };
    const covered = (pixels) => pixels.reduce((sum, value, i) => sum + (i % 4 === 3 && value > 0 ? 1 : 0), 0);
    const ball = new THREE.SphereGeometry(0.4, 24, 16);
    const instances = new THREE.InstancedMesh(ball, material(), 2);
    [-0.5, 0.5].forEach((x, i) => instances.setMatrixAt(i, new THREE.Matrix4().makeTranslation(x, 0, 0)));
    const meshes = [-0.5, 0.5].map((x) => {
      const mesh = new THREE.Mesh(ball, material());
      mesh.position.set(x, 0, 0);
      return mesh;
    });
    const result = { instances: lab.compared(draw(instances), draw(...meshes)).error };
    // A skin with one rotating bone looks the same as a rotating mesh.
    const skinned = ball.clone(), count = skinned.attributes.position.count;
    skinned.setAttribute("skinIndex", new THREE.Uint16BufferAttribute(new Uint16Array(4 * count), 4));
    skinned.setAttribute("skinWeight", new THREE.Float32BufferAttribute(Float32Array.from({ length: 4 * count },
      (_, i) => (i % 4 === 0 ? 1 : 0)), 4));
    const skin = new THREE.SkinnedMesh(skinned, material()), bone = new THREE.Bone();
    skin.add(bone);
    skin.bind(new THREE.Skeleton([bone]));
    const still = draw(skin);
    bone.rotation.z = 0.7;
    const bent = draw(skin), turned = new THREE.Mesh(ball, material());
    turned.rotation.z = 0.7;
    Object.assign(result, { skin: lab.compared(bent, draw(turned)).error, bent: lab.compared(bent, still).error,
      covered: covered(still) });
    const layered = (options) => draw(new THREE.Mesh(ball, material({ Material: THREE.MeshPhysicalMaterial,
      ...options })));
    const base = layered({});
    result.physical = lab.compared(base, draw(new THREE.Mesh(ball, material()))).error;
    for (const [name, options] of [["clearcoat", { clearcoat: 1 }], ["iridescence", { iridescence: 1 }],
      ["ior", { ior: 2.2 }], ["transmission", { transmission: 1, thickness: 0.2 }],
      ["alphaTest", { opacity: 0.4, alphaTest: 0.5 }],
      ["double-sided", { side: THREE.DoubleSide, flatShading: true }]])
      result[name] = lab.compared(layered(options), base).error;
    return result;
  });
  console.log("  geometries and layers, relative L1:", JSON.stringify(found));
  assert.ok(found.covered > 500);
  assert.ok(found.instances < 1e-3 && found.skin < 1e-3 && found.bent > 0.05 && found.physical < 1e-3);
  for (const name of ["clearcoat", "iridescence", "ior", "transmission", "alphaTest", "double-sided"])
    assert.ok(found[name] > 0.01, `${name} changes nothing`);
}

/** Materials share a texture and a program; materials without lobes are unchanged; disposal leaves nothing behind. */
async function sharingAndDisposal(page) {
  const found = await inPage(page, async () => {
    const { lab } = globalThis, { THREE, renderer } = lab;
    const counts = () => ({ textures: renderer.info.memory.textures, programs: renderer.info.programs.length,
      geometries: renderer.info.memory.geometries });
    const camera = lab.cameraAt(...lab.VIEWS.steep, 1), light = () => lab.directional([0.3, 0.8, 0.5]);
    const normals = await lab.loadNormals(), plain = lab.surface(normals);
    const calls = [];
    plain.onBeforeCompile = () => calls.push("plain");
    const scene = lab.sceneOf(plain, light());
    const before = lab.drawn(scene, camera, 64, 64), start = counts();
    const lobes = await lab.loadLobes("map.ktx2"), second = await lab.loadLobes("halves.ktx2");
    const materials = [0.2, 0.4, 0.6].map((roughness) => lab.surface(normals, { roughness }));
    materials.forEach((material) => lab.addLobes(material, lobes));
    const scenes = materials.map((material) => lab.sceneOf(material, light()));
    scenes.forEach((one) => lab.drawn(one, camera, 64, 64));
    const shared = counts();
    const again = lab.drawn(scene, camera, 64, 64);
    const plainTexts = renderer.info.programs.filter(({ fragmentShader }) =>
      !renderer.getContext().getShaderSource(fragmentShader).includes("multum")).length;
    const held = lab.lobesOf(materials[0]) === lobes && lab.lobesOf(plain) === null;
    // The material first gets other lobes, and then no lobes.
    lab.addLobes(materials[0], second);
    const other = lab.drawn(scenes[0], camera, 64, 64);
    lab.addPoints(materials[0], { evaluations: 4 });
    lab.removePoints(materials[0]);
    const removed = lab.drawn(scenes[0], camera, 64, 64);
    const fresh = lab.surface(normals, { roughness: 0.2 }), freshScene = lab.sceneOf(fresh, light());
    const untouched = lab.drawn(freshScene, camera, 64, 64);
    const own = Object.hasOwn(materials[0], "onBeforeCompile");
    for (const one of [...scenes, freshScene]) one.traverse((object) => { object.geometry?.dispose(); });
    [...materials, fresh].forEach((material) => material.dispose());
    lobes.dispose();
    lobes.dispose();
    second.dispose();
    const after = counts();
    let disposed = "";
    try {
      lab.addLobes(plain, lobes);
    } catch (error) {
      disposed = error.message;
    }
    return { same: lab.compared(again, before).error, start, shared, after, plainTexts, held, own, disposed,
      other: lab.compared(other, removed).error, removed: lab.compared(removed, untouched).error, calls: calls.length };
  });
  console.log("  sharing and disposal:", JSON.stringify(found));
  assert.equal(found.same, 0, "a material without lobes changes next to one with lobes");
  assert.equal(found.shared.textures, found.start.textures + 2, "all materials must share the lobes and their table");
  assert.equal(found.shared.programs, found.start.programs + 1, "equal materials must share one program");
  assert.ok(found.plainTexts > 0 && found.held && !found.own && found.calls > 0);
  assert.equal(found.removed, 0);
  assert.ok(found.other > 0.01);
  assert.deepEqual(found.after, found.start, "something stays behind");
  assert.match(found.disposed, /disposed/);
}

async function refusesBrokenFiles(page) {
  const good = readFileSync(inFolder("map.ktx2")), json = good.indexOf('{"version":1');
  const word = (at, value) => { const bytes = Buffer.from(good); bytes.writeUInt32LE(value, at); return bytes; };
  const said = (from, to) => {
    const bytes = Buffer.from(good), at = bytes.indexOf(from, json);
    assert.ok(at > 0 && from.length === to.length);
    bytes.write(to, at);
    return bytes;
  };
  const packed = readFileSync(inFolder("zstd.ktx2"));
  const damaged = Buffer.from(packed);
  damaged.fill(0xa5, packed.length - 400, packed.length - 100);
  const cases = {
    "no KTX2": [Buffer.from("no picture"), /cannot be read/],
    cut: [good.subarray(0, 90), /cannot be read/],
    shorter: [good.subarray(0, good.length - 9), /cannot be read|bytes of level/],
    format: [word(12, 99), /VkFormat 99/],
    wide: [word(20, 70000), /70000 x/],
    volume: [word(28, 4), /x 4 texels/],
    layers: [word(32, 7), /7 layers/],
    cube: [word(36, 6), /6 faces/],
    levels: [word(40, 40), /cannot be read|40 levels/],
    scheme: [word(44, 1), /supercompression 1/],
    length: [word(88, 16), /16 bytes of level 0/],
    version: [said('"version":1', '"version":7'), /version 7/],
    roughness: [said('"layersPerLobe"', '"meanCosine"   '), /found roughness in the lobes/],
    key: [said("{", "["), /not JSON/],
    "first level": [said('"firstLevel":1', '"firstLevel":0'), /first level 0/],
    wrap: [said("periodic", "aperiode"), /wrap modes aperiode/],
    columns: [said('"columns"', '"kolumns"'), /four columns/],
    map: [said('"mapWidth":128', '"mapWidth":999'), /a map of 999/],
    zstd: [damaged, /cannot be decompressed|bytes of level/],
  };
  for (const [name, [bytes, words]] of Object.entries(cases)) {
    const error = await inPage(page, async ([base64]) => {
      const data = Uint8Array.from(atob(base64), (one) => one.charCodeAt(0));
      const { lab } = globalThis;
      const loader = new lab.LobeLoader().detectSupport(lab.renderer);
      return loader.parse(data, "odd.ktx2").then(() => "", (one) => one.message);
    }, [bytes.toString("base64")]);
    assert.match(error, /^odd\.ktx2: found .*, expected /s, `${name}: ${error}`);
    assert.match(error, words, name);
  }
  const missing = await inPage(page, () => globalThis.lab.loadLobes("none.ktx2").then(() => "", (one) => one.message));
  assert.match(missing, /404/);
  const normal = await inPage(page, () => globalThis.lab.loadLobes("map_normal.png").then(() => "",
    (one) => one.message));
  assert.match(normal, /map_normal\.png: found a file that cannot be read/);
}

async function refusesMaterials(page) {
  const found = await inPage(page, async () => {
    const { lab } = globalThis, { THREE } = lab;
    const normalMap = await lab.loadNormals(), lobes = await lab.loadLobes("map.ktx2");
    const said = (act) => {
      try {
        act();
        return "";
      } catch (error) {
        return error.message;
      }
    };
    const tried = (material, given = lobes, options = {}) => said(() => lab.addLobes(material, given, options));
    const physical = (options) => lab.surface(normalMap, { Material: THREE.MeshPhysicalMaterial, ...options });
    const scaled = lab.surface(normalMap);
    scaled.normalScale.set(2, 2);
    return { basic: tried(new THREE.MeshBasicMaterial()), bare: tried(new THREE.MeshStandardMaterial()),
      object: tried(lab.surface(normalMap, { normalMapType: THREE.ObjectSpaceNormalMap })), scaled: tried(scaled),
      anisotropy: tried(physical({ anisotropy: 0.5 })), sheen: tried(physical({ sheen: 1 })),
      none: tried(lab.surface(normalMap), null), taps: tried(lab.surface(normalMap), lobes, { taps: 0.5 }),
      bias: tried(lab.surface(normalMap), lobes, { levelBias: NaN }),
      evaluations: tried(lab.surface(normalMap), lobes, { evaluations: 3 }),
      spend: tried(lab.surface(normalMap), lobes, { spend: "both" }),
      points: said(() => lab.addPoints(new THREE.MeshBasicMaterial())),
      pointCount: said(() => lab.addPoints(lab.surface(normalMap), { evaluations: 9 })),
      fine: tried(physical({ clearcoat: 1 })) };
  });
  const expected = { basic: /MeshBasicMaterial/, bare: /no normalMap/, object: /object space/,
    scaled: /normalScale 2, 2/, anisotropy: /anisotropy 0.5/, sheen: /sheen 1/, none: /no lobes/,
    taps: /taps: found 0.5/, bias: /levelBias: found NaN/,
    evaluations: /evaluations: found 3, expected one of 1, 2, 4, 8, 16/,
    spend: /spend: found both, expected one of auto/, points: /MeshBasicMaterial/,
    pointCount: /evaluations: found 9/, fine: /^$/ };
  for (const [name, words] of Object.entries(expected)) assert.match(found[name], words, name);
}

/** Reads MULTUM_lobes, valid and damaged. */
async function loadsModels(page, complaints) {
  const views = ["map_normal.png", "map.ktx2"].map((name) => readFileSync(inFolder(name)).toString("base64"));
  const load = (extension, top, material = {}) => inPage(page, async ([views, extension, top, material]) => {
    const { lab } = globalThis;
    const dressed = { normalTexture: { index: 0 }, pbrMetallicRoughness: { roughnessFactor: 0.9 }, ...material,
      extensions: { MULTUM_lobes: extension, ...material.extensions } };
    const more = { images: [{ bufferView: 1, mimeType: "image/png" }], textures: [{ source: 0 }],
      extensions: { MULTUM_lobes: top } };
    try {
      const gltf = await lab.loadModel(dressed, more, views);
      const drawn = gltf.scene.getObjectByProperty("isMesh", true).material;
      return { lobed: lab.lobesOf(drawn) !== null, roughness: drawn.roughness, count: gltf.userData.lobes.length };
    } catch (error) {
      return { error: error.message };
    }
  }, [views, extension, top, material]);
  const top = { lobes: [{ bufferView: 2, mimeType: "image/ktx2" }] };
  assert.deepEqual(await load({ lobes: 0, roughnessFactor: 0.25 }, top), { lobed: true, roughness: 0.25, count: 1 });
  assert.match((await load({ lobes: 5 }, top)).error, /lobes 5, expected the index/);
  assert.match((await load({}, top)).error, /lobes undefined, expected the index/);
  assert.match((await load({ lobes: 0 }, { lobes: [{ bufferView: 9 }] })).error, /lobes 0, expected the index/);
  assert.match((await load({ lobes: 0 }, { lobes: 7 })).error, /lobes 0, expected the index/);
  const coloured = async (colours) => (await load({ lobes: 0 }, { lobes: [{ bufferView: 2, colours }] })).error;
  assert.match(await coloured({ bufferView: 9 }), /colours of lobes 0: found buffer view 9, expected the index/);
  assert.match(await coloured({}), /colours of lobes 0: found buffer view undefined/);
  assert.match(await coloured({ bufferView: 1 }), /colours of lobes 0: found a file that cannot be read/);
  assert.match(await coloured({ bufferView: 2 }), /colours of lobes 0: found no key multumLobeColours/);
  const picture = await load({ lobes: 0 }, { lobes: [{ bufferView: 1 }] });
  assert.match(picture.error, /^MULTUM_lobes, lobes 0: found a file/);
  assert.deepEqual(complaints, []);
  const sheen = { extensions: { KHR_materials_sheen: { sheenColorFactor: [1, 1, 1] } } };
  const kept = await load({ lobes: 0, roughnessFactor: 0.25 }, top, sheen);
  assert.deepEqual(kept, { lobed: false, roughness: 0.9, count: 1 });
  assert.match(complaints.pop(), /found sheen 1, expected 0.*without lobes/);
}

function checkPackage() {
  const facts = JSON.parse(readFileSync(inFolder("shaders/three/package.json"), "utf8"));
  assert.equal(facts.name, "@multum/three");
  assert.ok(run("multum", "--version").includes(facts.version), "the package and multum have different versions");
}

let opened;
try {
  run("multum", "testmap", "map", "--size", "128");
  run("multum", "bake", "map_normal.png", "-o", "map.ndf.exr", "--green", "up", "--no-measure");
  for (const [name, ...more] of [["map"], ["rgba8", "--texels", "rgba8"], ["halves", "--texels", "rgba16f"],
    ["zstd", "--zstd", "9"]])
    run("multum", "export", "map.ndf.exr", "--lobes", ...more, "-o", `${name}.ktx2`);
  run("multum", "shaders", "-o", "shaders");
  checkPackage();
  opened = await openPage(chromium, { package: inFolder("shaders/three"), files: folder, script: "addon_page.js" });
  const { page, complaints } = opened;
  // The first part counts resources, so it needs a fresh page.
  for (const part of [sharingAndDisposal, besideMultumView, formatsAgree, lightsAgree, besideSupersampled,
    geometriesAndLayers]) {
    console.log(`${part.name}, ${Math.round(process.uptime())} s`);
    await part(page);
    assert.deepEqual(complaints, []);
  }
  await loadsModels(page, complaints);
  await refusesMaterials(page);
  await refusesBrokenFiles(page);
  console.log(`${Math.round(process.uptime())} s`);
} finally {
  await opened?.close();
  rmSync(folder, { recursive: true, force: true });
}
