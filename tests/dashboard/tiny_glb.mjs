// The smallest scenes there can be: one glowing square above another, as .glb or as .gltf with its .bin.

const kSquare = new Float32Array([-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1]);
const kIndices = new Uint16Array([0, 2, 1, 0, 3, 2]);

const binary = () => Buffer.concat([Buffer.from(kSquare.buffer), Buffer.from(kIndices.buffer)]);

/** `more` goes over the document's own members. */
function document(uri, more = {}) {
  return {
    asset: { version: "2.0" },
    scene: 0,
    scenes: [{ nodes: [0, 1] }],
    nodes: [{ mesh: 0 }, { mesh: 1, translation: [0, 1, 0] }],
    meshes: [0, 1].map((material) => ({ primitives: [{ attributes: { POSITION: 0 }, indices: 1, material }] })),
    materials: [
      { pbrMetallicRoughness: { baseColorFactor: [0.6, 0.3, 0.2, 1], metallicFactor: 0 }, doubleSided: true },
      { emissiveFactor: [1, 1, 1], doubleSided: true },
    ],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 4, type: "VEC3", min: [-1, 0, -1], max: [1, 0, 1] },
      { bufferView: 1, componentType: 5123, count: 6, type: "SCALAR" },
    ],
    bufferViews: [
      { buffer: 0, byteOffset: 0, byteLength: kSquare.byteLength },
      { buffer: 0, byteOffset: kSquare.byteLength, byteLength: kIndices.byteLength },
    ],
    buffers: [{ byteLength: kSquare.byteLength + kIndices.byteLength, ...(uri ? { uri } : {}) }],
    ...more,
  };
}

/** As a folder: file names and their contents. */
export const tinyGltf = (name, more = {}) => [
  { name: `${name}.gltf`, content: Buffer.from(JSON.stringify(document(`${name}.bin`, more))) },
  { name: `${name}.bin`, content: binary() },
];

export function tinyGlb(more = {}) {
  const padded = (bytes, fill) => Buffer.concat([bytes, Buffer.alloc((4 - (bytes.length % 4)) % 4, fill)]);
  const chunk = (type, bytes) => {
    const head = Buffer.alloc(8);
    head.writeUInt32LE(bytes.length, 0);
    head.write(type, 4, "latin1");
    return Buffer.concat([head, bytes]);
  };
  const body = Buffer.concat([
    chunk("JSON", padded(Buffer.from(JSON.stringify(document(null, more))), 0x20)),
    chunk("BIN\0", padded(binary(), 0)),
  ]);
  const head = Buffer.alloc(12);
  head.write("glTF", 0, "latin1");
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(12 + body.length, 8);
  return Buffer.concat([head, body]);
}
