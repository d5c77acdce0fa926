// The chunks of a .t4d file, for tests that inspect or modify one (t4d/formats/t4d/SPEC.md).
import { readFileSync } from 'node:fs';
import path from 'node:path';

import { root } from './t4d.mjs';

const fileHeaderBytes = 24;
const chunkHeaderBytes = 24;
const footerBytes = 40;

const padded = (bytes) => Math.ceil(bytes / 8) * 8;

/** The complete file of the specification, from its hex dump. */
export function exampleOfSpec() {
  const text = readFileSync(path.join(root, 't4d/formats/t4d/SPEC.md'), 'utf8');
  const dump = text.split('\n## A complete file\n')[1].split('```')[1];
  return Buffer.from(dump.trim().split('\n').map((line) => line.slice(6, 29)).join(' ')
    .replaceAll(' ', ''), 'hex');
}

/** [{type, at, payload}]: payloads are views of `bytes`. */
export function chunksOf(bytes) {
  const indexed = (bytes.readUInt32LE(12) & 1) !== 0;
  const end = bytes.length - (indexed ? footerBytes : 0);
  const chunks = [];
  for (let at = fileHeaderBytes; at < end;) {
    const length = Number(bytes.readBigUInt64LE(at + 8));
    const payload = bytes.subarray(at + chunkHeaderBytes, at + chunkHeaderBytes + length);
    chunks.push({ type: bytes.toString('latin1', at, at + 4), at, payload });
    at += chunkHeaderBytes + padded(length);
  }
  return chunks;
}

/** The JSON of HEAD. */
export const headOf = (bytes) => JSON.parse(new TextDecoder('utf-8', { fatal: true })
  .decode(chunksOf(bytes)[0].payload));

/** CRC-32C. */
export function crc32c(bytes) {
  let crc = 0xffffffff;
  for (const byte of bytes) {
    crc ^= byte;
    for (let bit = 0; bit < 8; ++bit) crc = (crc >>> 1) ^ (crc & 1 ? 0x82f63b78 : 0);
  }
  return (crc ^ 0xffffffff) >>> 0;
}

/** Recomputes the checksums of all chunks after payloads were modified in place. */
export function reseal(bytes) {
  for (const { at, payload } of chunksOf(bytes)) {
    bytes.writeUInt32LE(crc32c(payload), at + 16);
    bytes.writeUInt32LE(crc32c(bytes.subarray(at, at + 20)), at + 20);
  }
  return bytes;
}

/** The file with a different HEAD text; everything after it moves. */
export function withHead(bytes, text) {
  const [head, next] = chunksOf(bytes);
  const payload = Buffer.from(text);
  const header = Buffer.from(bytes.subarray(head.at, head.at + chunkHeaderBytes));
  header.writeBigUInt64LE(BigInt(payload.length), 8);
  const padding = Buffer.alloc(padded(payload.length) - payload.length);
  const moved = Buffer.concat(
    [bytes.subarray(0, head.at), header, payload, padding, bytes.subarray(next.at)]);
  const by = BigInt(moved.length - bytes.length);
  const move = (buffer, ...offsets) => {
    for (const at of offsets) {
      const offset = buffer.readBigUInt64LE(at);
      if (offset !== 0n) buffer.writeBigUInt64LE(offset + by, at);
    }
  };
  for (const chunk of chunksOf(moved)) {
    if (chunk.type === 'SLAB') move(chunk.payload, 16, 24, 32);
    if (chunk.type !== 'INDX') continue;
    for (let at = 8; at < chunk.payload.length; at += 64) {
      move(chunk.payload, at, at + 32, at + 40, at + 48);
    }
    const footer = moved.subarray(moved.length - footerBytes);
    move(footer, 0, 8, 16);
    footer.writeUInt32LE(crc32c(footer.subarray(0, 28)), 28);
  }
  return reseal(moved);
}
