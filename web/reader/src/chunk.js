import { crc32c } from './crc32c.js';
import { check } from './invalid.js';

export const fileHeaderBytes = 24;
export const chunkHeaderBytes = 32;
/** A chunk header in INDX: without its checksum. */
export const directoryEntryBytes = 28;
export const footerBytes = 40;

const signature = [0x89, 0x54, 0x34, 0x44, 0x0d, 0x0a, 0x1a, 0x0a];
const criticalTypes = new Set(['HEAD', 'CONN', 'LAYR', 'POSE', 'SLAB', 'DONE', 'INDX']);
const version = [1, 0];

export const padded = (bytes) => Math.ceil(bytes / 8) * 8;

export const viewOf = (bytes) => new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);

/** A u64 as a Number: beyond 2^53 it is rounded, and then no length or offset of a file. */
export const u64 = (view, at) => view.getUint32(at, true) + view.getUint32(at + 4, true) * 2 ** 32;

export const isSame = (some, others) =>
  some.length === others.length && some.every((value, i) => value === others[i]);

const isZero = (bytes) => bytes.every((byte) => byte === 0);

/** The first 20 bytes of a file, or their copy in INDX. */
export function parseFileHeader(bytes, at) {
  const view = viewOf(bytes);
  check(isSame([...bytes.subarray(0, 8)], signature), at, 'H1', 'not the signature of a .t4d file');
  return {
    version: [view.getUint16(8, true), view.getUint16(10, true)],
    hasIndex: (view.getUint32(12, true) & 1) === 1,
    checkRest() {
      check(this.version[0] === version[0], at + 8, 'H3',
        `a file of version ${this.version.join('.')}, this reader knows ${version.join('.')}`);
      check(view.getUint32(12, true) >>> 1 === 0, at + 12, 'H4', 'reserved flags');
      check(view.getUint32(16, true) === 0, at + 16, 'H5', 'reserved bytes');
      return this;
    },
  };
}

/** @param {Uint8Array} bytes the first 24 of the file */
export function readFileHeader(bytes) {
  const header = parseFileHeader(bytes, 0);
  check(viewOf(bytes).getUint32(20, true) === crc32c(bytes.subarray(0, 20)), 20, 'H2',
    'checksum of the file header');
  return header.checkRest();
}

/** Whether these last eight bytes are those of a file with index. */
export const isEndSignature = (bytes) => isSame([...bytes].reverse(), signature);

/**
 * @param {Uint8Array} bytes the last 40 of the file
 * @param {number} at their offset
 */
export function parseFooter(bytes, at) {
  const view = viewOf(bytes);
  check(isEndSignature(bytes.subarray(32)), at + 32, 'F1',
    'the end signature is missing; the file may have been cut off');
  check(view.getUint32(28, true) === crc32c(bytes.subarray(0, 28)), at + 28, 'F2',
    'checksum of the footer');
  const footer = {
    index: u64(view, 0), done: u64(view, 8), length: u64(view, 16), indexChecksum: view.getUint32(24, true),
  };
  check(footer.length === at + footerBytes, at + 16, 'F3',
    `the file has ${at + footerBytes} bytes, the footer says ${footer.length}`);
  return footer;
}

/**
 * The header of a chunk, from its 28 bytes without checksum.
 * @param {Uint8Array} bytes
 * @param {number} at the offset of the chunk
 */
export function parseChunkHeader(bytes, at) {
  const view = viewOf(bytes);
  const type = String.fromCharCode(...bytes.subarray(0, 4));
  check(/^([A-Z][A-Z0-9]{3}|[a-z][A-Za-z0-9]{3})$/.test(type), at, 'C1', 'type of the chunk');
  const flags = view.getUint32(4, true);
  check(flags >>> 1 === 0, at + 4, 'C2', 'reserved flags');
  const isCritical = (flags & 1) === 1;
  if (criticalTypes.has(type)) check(isCritical, at + 4, 'C7', `${type} is not critical`);
  if (type === 'PADD') check(!isCritical, at + 4, 'C7', 'PADD is critical');
  const length = u64(view, 8);
  return {
    type, isCritical, at, length, size: chunkHeaderBytes + padded(length),
    front: view.getUint32(16, true), blocks: view.getUint32(20, true),
    frontChecksum: view.getUint32(24, true), bytes,
  };
}

/**
 * A chunk, whole and with right checksums.
 * @param {Uint8Array} bytes from its header to its padding
 * @param {number} at its offset
 * @returns {{type: string, at: number, size: number, header: Uint8Array, checksum: number,
 *   fields: Uint8Array, blocks: Uint8Array[]}}
 */
export function parseChunk(bytes, at) {
  const header = bytes.subarray(0, directoryEntryBytes);
  const checksum = viewOf(bytes).getUint32(28, true);
  check(checksum === crc32c(header), at + 28, 'C4', 'header checksum');
  const { type, isCritical, length, size, front, blocks: count, frontChecksum } =
    parseChunkHeader(header, at);
  check(type !== 'HEAD' || length <= 16 << 20, at + 8, 'M1', 'HEAD above 16 MiB');
  check(size === bytes.length, at + 8, 'C3', `${length} bytes are not there`);
  const payload = bytes.subarray(chunkHeaderBytes, chunkHeaderBytes + length);
  check(front <= length, at + 16, 'C9', 'front beyond the payload');
  check(frontChecksum === crc32c(payload.subarray(0, front)), at + 24, 'C5', 'front checksum');
  check(criticalTypes.has(type) || !isCritical, at, 'C8', `unknown critical chunk ${type}`);
  check(isZero(bytes.subarray(chunkHeaderBytes + length)), at, 'C6', 'padding');
  check(count === 0 || (type !== 'HEAD' && type !== 'DONE'), at + 20, 'C11', `${type} has blocks`);
  check(count > 0 ? front % 8 === 0 && 8 * count <= front : front === length, at + 16, 'C9',
    'front of the payload');
  const blocks = [];
  if (count > 0) {
    const view = viewOf(payload);
    let begin = front;
    for (let i = 0; i < count; ++i) {
      const end = begin + view.getUint32(8 * i, true);
      check(padded(end) <= length, at + 32 + 8 * i, 'C9', 'a block beyond the payload');
      const block = payload.subarray(begin, end);
      check(view.getUint32(8 * i + 4, true) === crc32c(block), at + 36 + 8 * i, 'C10',
        'checksum of a block');
      check(isZero(payload.subarray(end, padded(end))), at, 'C6', 'padding of a block');
      blocks.push(block);
      begin = padded(end);
    }
    check(begin === length, at + 8, 'C9', 'the blocks do not fill the payload');
  }
  return { type, at, size, header, checksum, fields: payload.subarray(8 * count, front), blocks };
}

/** Reads the fields of a chunk one after another, and the blocks of their arrays. */
export class Fields {
  /** @param {string} endRule what fields break that end too early or too late */
  constructor(chunk, endRule) {
    Object.assign(this, { at: chunk.at, bytes: chunk.fields, blocks: chunk.blocks, endRule });
    this.view = viewOf(this.bytes);
    this.place = 0;
    this.nextBlock = 0;
  }

  /** The place of the next `bytes` bytes. */
  skip(bytes) {
    const place = this.place;
    check(place + bytes <= this.bytes.length, this.at, this.endRule, 'the fields end too early');
    this.place += bytes;
    return place;
  }

  take(bytes) {
    const place = this.skip(bytes);
    return this.bytes.subarray(place, place + bytes);
  }

  u8() { return this.view.getUint8(this.skip(1)); }

  u32() { return this.view.getUint32(this.skip(4), true); }

  u64() { return u64(this.view, this.skip(8)); }

  f64() { return this.view.getFloat64(this.skip(8), true); }

  f64s(count) {
    const place = this.skip(8 * count);
    return Float64Array.from({ length: count }, (_, i) => this.view.getFloat64(place + 8 * i, true));
  }

  zeros(bytes, rule) {
    check(isZero(this.take(bytes)), this.at, rule, 'reserved bytes are not 0');
  }

  pad(rule) {
    // Fields begin at a multiple of 8.
    this.zeros(padded(this.place) - this.place, rule);
  }

  finish() {
    check(this.place === this.bytes.length, this.at, this.endRule, 'bytes behind the fields');
    check(this.nextBlock === this.blocks.length, this.at, this.endRule, 'blocks are left');
  }
}
