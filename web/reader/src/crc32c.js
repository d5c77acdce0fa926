// Eight bytes a step: table k has the checksums of a byte with k zero bytes behind it.
const tables = Array.from({ length: 8 }, () => new Uint32Array(256));
for (let value = 0; value < 256; ++value) {
  let crc = value;
  for (let bit = 0; bit < 8; ++bit) crc = (crc >>> 1) ^ (crc & 1 ? 0x82f63b78 : 0);
  tables[0][value] = crc;
}
for (let k = 1; k < 8; ++k) {
  for (let value = 0; value < 256; ++value) {
    const before = tables[k - 1][value];
    tables[k][value] = (before >>> 8) ^ tables[0][before & 0xff];
  }
}
const [t0, t1, t2, t3, t4, t5, t6, t7] = tables;

/**
 * CRC-32C of the bytes, after others that have the checksum `before`.
 * @param {Uint8Array} bytes
 * @param {number} [before]
 * @returns {number}
 */
export function crc32c(bytes, before = 0) {
  let crc = ~before;
  let i = 0;
  for (const end = bytes.length - 7; i < end; i += 8) {
    crc ^= bytes[i] | (bytes[i + 1] << 8) | (bytes[i + 2] << 16) | (bytes[i + 3] << 24);
    crc = t7[crc & 0xff] ^ t6[(crc >>> 8) & 0xff] ^ t5[(crc >>> 16) & 0xff] ^ t4[crc >>> 24]
      ^ t3[bytes[i + 4]] ^ t2[bytes[i + 5]] ^ t1[bytes[i + 6]] ^ t0[bytes[i + 7]];
  }
  for (; i < bytes.length; ++i) crc = (crc >>> 8) ^ t0[(crc ^ bytes[i]) & 0xff];
  return ~crc >>> 0;
}
