// Reads what packets.py writes: packets of plain data with named arrays behind them.

const TYPES = {
  i1: Int8Array, u1: Uint8Array, i2: Int16Array, u2: Uint16Array,
  i4: Int32Array, u4: Uint32Array, f4: Float32Array, f8: Float64Array,
};
const MAGIC = 0x31505753; // "SWP1", read as a little-endian number

/** All packets of a buffer, one after the other: `{facts, arrays}`. */
export function readPackets(buffer) {
  const view = new DataView(buffer);
  const packets = [];
  let at = 0;
  while (at < buffer.byteLength) {
    if (view.getUint32(at, true) !== MAGIC) throw new Error("these bytes are not mission data");
    const textBytes = view.getUint32(at + 4, true);
    const arrayBytes = view.getUint32(at + 8, true);
    const text = new TextDecoder().decode(new Uint8Array(buffer, at + 12, textBytes));
    const facts = JSON.parse(text);
    const base = at + 12 + textBytes;
    const arrays = {};
    for (const [name, place] of Object.entries(facts.arrays)) {
      arrays[name] = new TYPES[place.type](buffer, base + place.at, place.length);
    }
    packets.push({ facts, arrays });
    at = base + arrayBytes;
  }
  return packets;
}

/** Bytes behind a base64 text. */
export function fromBase64(text) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

/** What was gzipped, as an ArrayBuffer. */
export async function unzip(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}
