// Generates a small torus in every model format that the page reads.

function torus(around = 24, across = 12) {
  const vertices = [], faces = [];
  for (let i = 0; i < around; i++) {
    for (let j = 0; j < across; j++) {
      const [a, b] = [2 * Math.PI * i / around, 2 * Math.PI * j / across];
      const r = 0.7 + 0.3 * Math.cos(b);
      vertices.push([r * Math.cos(a), r * Math.sin(a), 0.3 * Math.sin(b)].map(Math.fround));
      const at = (i, j) => (i % around) * across + j % across;
      faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
    }
  }
  return { vertices, faces };
}

const { vertices, faces } = torus();
export const TRIANGLES = faces.length;

const obj = [...vertices.map((v) => `v ${v.join(" ")}`), ...faces.map((f) => `f ${f.map((i) => i + 1).join(" ")}`)].join("\n");

const ply = ["ply", "format ascii 1.0", `element vertex ${vertices.length}`, "property float x", "property float y",
  "property float z", `element face ${faces.length}`, "property list uchar int vertex_indices", "end_header",
  ...vertices.map((v) => v.join(" ")), ...faces.map((f) => `3 ${f.join(" ")}`), ""].join("\n");

function stl() {
  const out = Buffer.alloc(84 + 50 * faces.length);
  out.writeUInt32LE(faces.length, 80);
  faces.forEach((face, i) => {
    face.forEach((index, k) => vertices[index].forEach((x, axis) => out.writeFloatLE(x, 84 + 50 * i + 12 + 12 * k + 4 * axis)));
  });
  return out;
}

function glb() {
  const positions = Buffer.alloc(12 * vertices.length), indices = Buffer.alloc(4 * 3 * faces.length);
  vertices.flat().forEach((x, i) => positions.writeFloatLE(x, 4 * i));
  faces.flat().forEach((x, i) => indices.writeUInt32LE(x, 4 * i));
  const bin = Buffer.concat([positions, indices]);
  const bounds = (pick) => [0, 1, 2].map((k) => pick(...vertices.map((v) => v[k])));
  let json = JSON.stringify({
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    buffers: [{ byteLength: bin.length }],
    bufferViews: [{ buffer: 0, byteOffset: 0, byteLength: positions.length },
      { buffer: 0, byteOffset: positions.length, byteLength: indices.length }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: vertices.length, type: "VEC3", min: bounds(Math.min), max: bounds(Math.max) },
      { bufferView: 1, componentType: 5125, count: 3 * faces.length, type: "SCALAR" }],
  });
  json = json.padEnd(Math.ceil(json.length / 4) * 4);
  const chunk = (type, data) => {
    const head = Buffer.alloc(8);
    head.writeUInt32LE(data.length, 0);
    head.write(type, 4, "latin1");
    return Buffer.concat([head, data]);
  };
  const chunks = Buffer.concat([chunk("JSON", Buffer.from(json)), chunk("BIN\0", bin)]);
  const head = Buffer.alloc(12);
  head.write("glTF", 0, "latin1");
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(12 + chunks.length, 8);
  return Buffer.concat([head, chunks]);
}

export const MODELS = { "torus.obj": Buffer.from(obj), "torus.ply": Buffer.from(ply), "torus.stl": stl(), "torus.glb": glb() };

/** Invalid files, each with a pattern that the error message must match. */
export const BROKEN = {
  "cut.obj": [Buffer.from("v 0 0 0\nv 1 0 0\nf 1 2 3\n"), /cut\.obj/],
  "cut.stl": [stl().subarray(0, 200), /cut\.stl/],
  "cut.glb": [glb().subarray(0, 300), /cut\.glb/],
  "noise.ply": [Buffer.from("ply\nformat ascii 1.0\nelement vertex 99999999999\nend_header\n"), /noise\.ply/],
  "empty.obj": [Buffer.alloc(0), /empty/],
  "picture.png": [Buffer.from([137, 80, 78, 71, 13, 10, 26, 10, 0, 0]), /picture\.png/],
};
