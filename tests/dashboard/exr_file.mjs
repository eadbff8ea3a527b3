// An OpenEXR file made by hand, so that a test knows every value in it, NaN and infinities too.

const kFloat = 2;

/** Scan lines without compression; channels are floats: {"R": values, "layer.Z": values}, row 0 at the top. */
export function exrFile(width, height, channels) {
  const names = Object.keys(channels).sort();
  const head = [];
  const int = (value) => {
    const bytes = Buffer.alloc(4);
    bytes.writeInt32LE(value);
    return bytes;
  };
  const float = (value) => {
    const bytes = Buffer.alloc(4);
    bytes.writeFloatLE(value);
    return bytes;
  };
  const text = (value) => Buffer.from(`${value}\0`, "latin1");
  const attribute = (name, type, ...parts) => {
    const content = Buffer.concat(parts);
    head.push(text(name), text(type), int(content.length), content);
  };
  const box = Buffer.concat([0, 0, width - 1, height - 1].map(int));
  attribute("channels", "chlist", ...names.map((name) => Buffer.concat([text(name), int(kFloat), int(0), int(1), int(1)])), Buffer.from([0]));
  attribute("compression", "compression", Buffer.from([0]));
  attribute("dataWindow", "box2i", box);
  attribute("displayWindow", "box2i", box);
  attribute("lineOrder", "lineOrder", Buffer.from([0]));
  attribute("pixelAspectRatio", "float", float(1));
  attribute("screenWindowCenter", "v2f", float(0), float(0));
  attribute("screenWindowWidth", "float", float(1));
  const header = Buffer.concat([int(20000630), int(2), ...head, Buffer.from([0])]);
  const lineBytes = 8 + 4 * width * names.length;
  const offsets = Buffer.alloc(8 * height);
  const lines = [];
  for (let y = 0; y < height; ++y) {
    offsets.writeBigUInt64LE(BigInt(header.length + offsets.length + y * lineBytes), 8 * y);
    const line = Buffer.alloc(lineBytes);
    line.writeInt32LE(y, 0);
    line.writeInt32LE(lineBytes - 8, 4);
    names.forEach((name, k) => {
      for (let x = 0; x < width; ++x) line.writeFloatLE(channels[name][y * width + x], 8 + 4 * (k * width + x));
    });
    lines.push(line);
  }
  return Buffer.concat([header, offsets, ...lines]);
}
