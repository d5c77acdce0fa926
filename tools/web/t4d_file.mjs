// The chunks of a .t4d file, for tests that inspect or modify one (formats/t4d/SPEC.md).
import { readFileSync } from 'node:fs';
import path from 'node:path';

import { root } from './t4d.mjs';

const fileHeaderBytes = 24;
const chunkHeaderBytes = 32;
const directoryEntryBytes = 28;
const footerBytes = 40;

const padded = (bytes) => Math.ceil(bytes / 8) * 8;

/** The complete file of the specification, from its hex dump. */
export function exampleOfSpec() {
  const text = readFileSync(path.join(root, 'formats/t4d/SPEC.md'), 'utf8');
  const dump = text.split('\n## A complete file\n')[1].split('```')[1];
  return Buffer.from(dump.trim().split('\n').map((line) => line.slice(6, 29)).join(' ')
    .replaceAll(' ', ''), 'hex');
}

/** [{type, at, payload, fields, blocks}]: payloads and their parts are views of `bytes`. */
export function chunksOf(bytes) {
  const indexed = (bytes.readUInt32LE(12) & 1) !== 0;
  const end = bytes.length - (indexed ? footerBytes : 0);
  const chunks = [];
  for (let at = fileHeaderBytes; at < end;) {
    const length = Number(bytes.readBigUInt64LE(at + 8));
    const front = bytes.readUInt32LE(at + 16);
    const count = bytes.readUInt32LE(at + 20);
    const payload = bytes.subarray(at + chunkHeaderBytes, at + chunkHeaderBytes + length);
    const blocks = [];
    for (let i = 0, begin = front; i < count; ++i) {
      const size = payload.readUInt32LE(8 * i);
      blocks.push(payload.subarray(begin, begin + size));
      begin += padded(size);
    }
    const fields = payload.subarray(8 * count, front);
    chunks.push({ type: bytes.toString('latin1', at, at + 4), at, payload, fields, blocks });
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

/** Recomputes the checksums of all chunks after payloads were modified in place, and what INDX, whose
    arrays must not be compressed, and the footer say of them. */
export function reseal(bytes) {
  const chunks = chunksOf(bytes);
  const done = chunks.findIndex(({ type }) => type === 'DONE');
  for (const { type, at, payload, blocks } of chunks) {
    if (type === 'INDX') {
      chunks.slice(0, done + 1).forEach((chunk, i) => {
        bytes.copy(blocks[1], i * directoryEntryBytes, chunk.at, chunk.at + directoryEntryBytes);
      });
    }
    blocks.forEach((block, i) => payload.writeUInt32LE(crc32c(block), 8 * i + 4));
    const front = bytes.readUInt32LE(at + 16);
    bytes.writeUInt32LE(crc32c(payload.subarray(0, front)), at + 24);
    bytes.writeUInt32LE(crc32c(bytes.subarray(at, at + 28)), at + 28);
    if (type !== 'INDX') continue;
    const footer = bytes.subarray(bytes.length - footerBytes);
    footer.writeUInt32LE(bytes.readUInt32LE(at + 28), 24);
    footer.writeUInt32LE(crc32c(footer.subarray(0, 28)), 28);
  }
  return bytes;
}

/** A chunk as stored; the checksums are those of another. */
function chunkOf(header, fields, blocks) {
  const whole = (part) => Buffer.concat([part, Buffer.alloc(padded(part.length) - part.length)]);
  const table = Buffer.alloc(8 * blocks.length);
  blocks.forEach((block, i) => table.writeUInt32LE(block.length, 8 * i));
  const payload = Buffer.concat([table, fields, ...blocks.map(whole)]);
  const changed = Buffer.from(header);
  changed.writeBigUInt64LE(BigInt(payload.length), 8);
  changed.writeUInt32LE(table.length + fields.length, 16);
  return Buffer.concat([changed, whole(payload)]);
}

/** The file with a different HEAD text; everything after it moves. */
export function withHead(bytes, text) {
  const chunks = chunksOf(bytes);
  const head = Buffer.from(text);
  const by = BigInt(padded(head.length) - padded(chunks[0].payload.length));
  const move = (buffer, ...offsets) => {
    for (const at of offsets) {
      const offset = buffer.readBigUInt64LE(at);
      if (offset !== 0n) buffer.writeBigUInt64LE(offset + by, at);
    }
  };
  const made = chunks.map(({ type, at, fields, blocks }) => {
    let ownFields = Buffer.from(fields);
    const ownBlocks = blocks.map((block) => Buffer.from(block));
    if (type === 'HEAD') ownFields = head;
    if (type === 'INDX') {
      ownFields.writeBigUInt64LE(BigInt(head.length), 24 + 8);
      ownBlocks[0] = head;
    }
    return chunkOf(bytes.subarray(at, at + chunkHeaderBytes), ownFields, ownBlocks);
  });
  const moved = Buffer.concat(
    [bytes.subarray(0, fileHeaderBytes), ...made, bytes.subarray(bytes.length - footerBytes)]);
  const footer = moved.subarray(moved.length - footerBytes);
  move(footer, 0, 8);
  footer.writeBigUInt64LE(BigInt(moved.length), 16);
  return reseal(moved);
}
