// CRC-32 as zlib and PNG have it (formats/container.md 1), four bytes at once.

/** Four tables of 256: how a byte changes the sum when 0 to 3 bytes follow it. */
const TABLES = tables();

function tables(): Uint32Array {
  const found = new Uint32Array(1024);
  for (let byte = 0; byte < 256; byte += 1) {
    let sum = byte;
    for (let bit = 0; bit < 8; bit += 1) {
      sum = (sum >>> 1) ^ (sum & 1 ? 0xedb88320 : 0);
    }
    found[byte] = sum;
  }
  for (let at = 256; at < 1024; at += 1) {
    const before = found[at - 256];
    found[at] = (before >>> 8) ^ found[before & 0xff];
  }
  return found;
}

/** The CRC-32 of bytes, 0 to 2^32 - 1. */
export function crc32(bytes: Uint8Array): number {
  let sum = 0xffffffff;
  const words = bytes.length - (bytes.length % 4);
  let at = 0;
  for (; at < words; at += 4) {
    const word = sum ^ (bytes[at] | (bytes[at + 1] << 8) | (bytes[at + 2] << 16) | (bytes[at + 3] << 24));
    sum =
      TABLES[768 + (word & 0xff)] ^
      TABLES[512 + ((word >>> 8) & 0xff)] ^
      TABLES[256 + ((word >>> 16) & 0xff)] ^
      TABLES[word >>> 24];
  }
  for (; at < bytes.length; at += 1) {
    sum = (sum >>> 8) ^ TABLES[(sum ^ bytes[at]) & 0xff];
  }
  return ~sum >>> 0;
}
