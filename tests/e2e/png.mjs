// Reads the PNG of a screenshot (8 bits, RGB or RGBA, not interlaced) into RGB pixels.
import { inflateSync } from "node:zlib";

export function decodePng(file) {
  const header = {
    width: file.readUInt32BE(16),
    height: file.readUInt32BE(20),
    depth: file[24],
    type: file[25],
    interlace: file[28],
  };
  const channels = { 2: 3, 6: 4 }[header.type];
  if (header.depth !== 8 || channels === undefined || header.interlace !== 0)
    throw new Error(`expected an 8 bit RGB(A) PNG, found ${JSON.stringify(header)}`);
  const raw = inflateSync(
    Buffer.concat([...chunks(file)].filter(({ type }) => type === "IDAT").map(({ body }) => body)),
  );
  const stride = header.width * channels;
  const pixels = Buffer.alloc(stride * header.height);
  for (let y = 0; y < header.height; ++y) unfilter(raw, pixels, y, stride, channels);
  return {
    width: header.width,
    height: header.height,
    at: (x, y) => [...pixels.subarray(y * stride + x * channels, y * stride + x * channels + 3)],
  };
}

function* chunks(file) {
  for (let at = 8; at + 8 <= file.length; ) {
    const length = file.readUInt32BE(at);
    yield { type: file.toString("latin1", at + 4, at + 8), body: file.subarray(at + 8, at + 8 + length) };
    at += length + 12;
  }
}

function unfilter(raw, pixels, y, stride, channels) {
  const filter = raw[y * (stride + 1)];
  for (let i = 0; i < stride; ++i) {
    const left = i >= channels ? pixels[y * stride + i - channels] : 0;
    const up = y > 0 ? pixels[(y - 1) * stride + i] : 0;
    const corner = y > 0 && i >= channels ? pixels[(y - 1) * stride + i - channels] : 0;
    pixels[y * stride + i] =
      raw[y * (stride + 1) + 1 + i] + [0, left, up, (left + up) >> 1, paeth(left, up, corner)][filter];
  }
}

function paeth(a, b, c) {
  const p = a + b - c;
  const [pa, pb, pc] = [Math.abs(p - a), Math.abs(p - b), Math.abs(p - c)];
  if (pa <= pb && pa <= pc) return a;
  return pb <= pc ? b : c;
}
