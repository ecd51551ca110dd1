// SPDX-License-Identifier: MIT OR Apache-2.0
// The page's side: a CesiumJS globe at a given camera, regions on it in two ways, frames and what they cost.
// Loaded before CesiumJS, so that its calls of WebGL are counted.
"use strict";
window.terrafillPeer = (() => {
  const SKY = 0, BARE_BLUE = 255; // a region's id is in red and green
  const SETTLED_FRAMES = 4; // a hidden or shown collection is baked into tiles over a few frames
  const LIMIT_MS = 240_000;

  // ---- what WebGL is asked for ----
  const done = { draws: 0, vertices: 0, uploads: 0, uploaded: 0, buffers: 0, programs: 0 };
  const held = { vertex: 0, index: 0, texture: 0, buffers: 0 };
  const sizes = new Map(), bound = new Map();
  let unit = 0;
  const hold = (thing, kind, bytes) => {
    release(thing);
    sizes.set(thing, [kind, bytes]);
    held[kind] += bytes;
    if (kind !== "texture") held.buffers += 1;
  };
  const release = (thing) => {
    if (!sizes.has(thing)) return;
    const [kind, bytes] = sizes.get(thing);
    held[kind] -= bytes;
    if (kind !== "texture") held.buffers -= 1;
    sizes.delete(thing);
  };
  const prototype = WebGL2RenderingContext.prototype, GL = WebGL2RenderingContext;
  const watch = (name, look) => {
    const original = prototype[name];
    prototype[name] = function (...given) { look(given); return original.apply(this, given); };
  };
  const upload = (bytes) => { done.uploads += 1; done.uploaded += bytes; };
  const drawn = (count) => { done.draws += 1; done.vertices += count; };
  const PARTS = { [GL.RGBA]: 4, [GL.RGB]: 3, [GL.RG]: 2, [GL.DEPTH_STENCIL]: 1, [GL.RED]: 1 };
  const BYTES = { [GL.UNSIGNED_BYTE]: 1, [GL.FLOAT]: 4, [GL.HALF_FLOAT]: 2, [GL.UNSIGNED_INT]: 4, [GL.UNSIGNED_SHORT]: 2, [GL.UNSIGNED_INT_24_8]: 4 };
  watch("bindBuffer", ([target, buffer]) => bound.set(target, buffer));
  watch("bufferData", ([target, data]) => {
    const bytes = typeof data === "number" ? data : data?.byteLength ?? 0;
    hold(bound.get(target), target === GL.ELEMENT_ARRAY_BUFFER ? "index" : "vertex", bytes);
    if (typeof data !== "number") upload(bytes);
  });
  watch("bufferSubData", ([, , data]) => upload(data.byteLength));
  watch("activeTexture", ([chosen]) => { unit = chosen; });
  watch("bindTexture", ([target, texture]) => bound.set(`${unit} ${target}`, texture));
  watch("texImage2D", (given) => {
    const [target, level, , width, height, , format, type, data] = given;
    if (given.length < 9 || level > 0 || target !== GL.TEXTURE_2D) return;
    const bytes = width * height * (PARTS[format] ?? 4) * (BYTES[type] ?? 4);
    hold(bound.get(`${unit} ${target}`), "texture", bytes);
    if (data) upload(bytes);
  });
  watch("texSubImage2D", (given) => upload(given.length < 9 ? 0 : given[4] * given[5] * (PARTS[given[6]] ?? 4) * (BYTES[given[7]] ?? 4)));
  watch("deleteBuffer", ([buffer]) => release(buffer));
  watch("deleteTexture", ([texture]) => release(texture));
  watch("createBuffer", () => { done.buffers += 1; });
  watch("linkProgram", () => { done.programs += 1; });
  watch("drawElements", ([, count]) => drawn(count));
  watch("drawArrays", ([, , count]) => drawn(count));
  watch("drawElementsInstanced", ([, count, , , instances]) => drawn(count * instances));
  watch("drawArraysInstanced", ([, , count, instances]) => drawn(count * instances));

  // ---- the globe ----
  let scene, gl, instant, fills = [], isReady = () => true, isShown = true;
  const one = new Uint8Array(4);
  const frame = () => {
    scene.render(instant);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, one); // waits for the device
  };
  const frames = (count) => { for (let i = 0; i < count; i += 1) frame(); };

  // An ellipsoid without pictures, sky, light or smoothing: what is left is the globe and what lies on it.
  async function open(tilesPx) {
    const { scene: made } = new Cesium.CesiumWidget("globe", {
      baseLayer: false, contextOptions: { webgl: { alpha: false, antialias: false, stencil: true } }, creditContainer: document.createElement("div"),
      msaaSamples: 1, scene3DOnly: true, skyAtmosphere: false, skyBox: false, terrainProvider: new Cesium.EllipsoidTerrainProvider(), useDefaultRenderLoop: false,
    });
    scene = made;
    gl = scene.context._gl;
    instant = Cesium.JulianDate.fromIso8601("2026-01-01T00:00:00Z");
    scene.rethrowRenderErrors = true;
    scene.backgroundColor = Cesium.Color.BLACK;
    scene.fog.enabled = false;
    for (const light of [scene.sun, scene.moon]) if (light) light.show = false;
    scene.postProcessStages.fxaa.enabled = false;
    scene.globe.baseColor = Cesium.Color.BLUE;
    scene.globe.maximumScreenSpaceError = tilesPx;
    scene.globe.enableLighting = false;
    scene.globe.showGroundAtmosphere = false;
    scene.screenSpaceCameraController.enableInputs = false;
    await Cesium.GroundPrimitive.initializeTerrainHeights();
    frame();
    const debug = gl.getExtension("WEBGL_debug_renderer_info");
    return { cesium: Cesium.VERSION, renderer: gl.getParameter(debug ? debug.UNMASKED_RENDERER_WEBGL : gl.RENDERER), size: [gl.drawingBufferWidth, gl.drawingBufferHeight] };
  }

  async function settle() {
    const start = performance.now();
    for (let quiet = 0; quiet < SETTLED_FRAMES; quiet = scene.globe.tilesLoaded && isReady() ? quiet + 1 : 0) {
      if (performance.now() - start > LIMIT_MS) throw new Error(`tiles or regions are not ready after ${LIMIT_MS / 1000} s`);
      frame();
      await new Promise((next) => setTimeout(next, 1));
    }
  }

  // Metres and unit vectors, ECEF; the angle, in radians, is that of the image's longer side.
  async function view({ eye, direction, up, right, angle }) {
    const { camera } = scene, vector = (xyz) => new Cesium.Cartesian3(...xyz);
    camera.frustum.fov = angle;
    camera.position = vector(eye);
    camera.direction = vector(direction);
    camera.up = vector(up);
    camera.right = vector(right);
    await settle();
    return { view: Cesium.Matrix4.toArray(camera.viewMatrix), projection: Cesium.Matrix4.toArray(camera.frustum.projectionMatrix) };
  }

  const colour = (id) => Cesium.Color.fromBytes(id & 255, id >> 8, 0, 255);

  // A stencil volume for each polygon: with one for several, pixels get wrong colours.
  function volumes(polygons) {
    const ring = (degrees) => Cesium.Cartesian3.fromDegreesArray(degrees.flat());
    const hierarchy = ([shell, ...holes]) => new Cesium.PolygonHierarchy(ring(shell), holes.map((hole) => new Cesium.PolygonHierarchy(ring(hole))));
    const primitives = polygons.map(({ id, rings }) => new Cesium.GroundPrimitive({
      asynchronous: false,
      geometryInstances: new Cesium.GeometryInstance({
        attributes: { color: Cesium.ColorGeometryInstanceAttribute.fromColor(colour(id)) },
        geometry: new Cesium.PolygonGeometry({ polygonHierarchy: hierarchy(rings) }),
      }),
    }));
    isReady = () => primitives.every((primitive) => primitive.ready);
    const all = new Cesium.PrimitiveCollection();
    for (const primitive of primitives) all.add(primitive);
    return all;
  }

  // Edges in a grid for each tile of terrain, looked up in the globe's shader.
  function lookup(polygons) {
    const count = (of) => polygons.reduce((sum, polygon) => sum + of(polygon), 0);
    const points = ({ rings }) => rings.reduce((sum, ring) => sum + ring.length, 0);
    const all = new Cesium.BufferPolygonCollection({
      // Left to itself it takes too small a part of the globe.
      boundingVolume: new Cesium.BoundingSphere(Cesium.Cartesian3.ZERO, 6.4e6), heightReference: Cesium.HeightReference.CLAMP_TO_TERRAIN,
      holeCountMax: Math.max(1, count(({ rings }) => rings.length - 1)), primitiveCountMax: polygons.length, triangleCountMax: 1, vertexCountMax: count(points),
    });
    const place = new Cesium.Cartesian3(), item = new Cesium.BufferPolygon();
    for (const polygon of polygons) {
      const positions = new Float64Array(3 * points(polygon)), holes = [];
      let at = 0;
      for (const ring of polygon.rings) {
        if (at > 0) holes.push(at / 3);
        for (const [longitude, latitude] of ring) {
          Cesium.Cartesian3.pack(Cesium.Cartesian3.fromDegrees(longitude, latitude, 0, undefined, place), positions, at);
          at += 3;
        }
      }
      all.add({ holes: new Uint32Array(holes), material: new Cesium.BufferPolygonMaterial({ color: colour(polygon.id) }), positions }, item);
    }
    return all;
  }

  // What is held for the regions, bytes.
  async function add(way, polygons) {
    const before = { ...held };
    fills = scene.primitives.add({ lookup, volumes }[way](polygons));
    await settle();
    return Object.fromEntries(Object.entries(held).map(([kind, bytes]) => [kind, bytes - before[kind]]));
  }

  function show(shown) {
    fills.show = shown;
    if (shown !== isShown) frames(SETTLED_FRAMES);
    isShown = shown;
  }

  // Wall clock of so many frames, milliseconds.
  function time(count) {
    const start = performance.now();
    frames(count);
    return performance.now() - start;
  }

  // What a frame asks for because of the regions: with them less without.
  function work() {
    const of = (shown) => {
      show(shown);
      const before = { ...done };
      frame();
      return Object.fromEntries(Object.entries(done).map(([what, count]) => [what, count - before[what]]));
    };
    const hidden = of(false), full = of(true);
    return Object.fromEntries(Object.entries(full).map(([what, count]) => [what, count - hidden[what]]));
  }

  // Runs of equal pixels from the upper left corner, row by row: region or -1 bare surface, -2 sky, -3 any other colour; then how many.
  function picture() {
    show(true);
    frame();
    const [width, height] = [gl.drawingBufferWidth, gl.drawingBufferHeight], rgba = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, rgba);
    const meaning = (at) => {
      const [red, green, blue] = [rgba[at], rgba[at + 1], rgba[at + 2]], id = red + 256 * green;
      if (blue === 0) return id === SKY ? -2 : id;
      return blue === BARE_BLUE && id === 0 ? -1 : -3;
    };
    const runs = [];
    for (let row = height - 1; row >= 0; row -= 1) {
      for (let column = 0; column < width; column += 1) {
        const found = meaning(4 * (row * width + column));
        if (runs.length > 0 && runs.at(-2) === found) runs[runs.length - 1] += 1; else runs.push(found, 1);
      }
    }
    return runs;
  }

  return { add, open, picture, show, time, view, work };
})();
