import { check } from './invalid.js';
import { decompress } from './zstd.js';

/** The types of scalars by number; views of the bytes of a file, which are little-endian. */
const scalarTypes = [null, Uint8Array, Int8Array, Uint16Array, Int16Array, Uint32Array, Int32Array,
  BigUint64Array, BigInt64Array, Float32Array, Float64Array];
export const u32Type = 5;
export const i32Type = 6;
export const f32Type = 9;
export const f64Type = 10;

const blockRows = 65536;
const mostBytes = 2 ** 31;

/**
 * The record of an array at the next fields, and its blocks.
 * @param {import('./chunk.js').Fields} fields
 */
export function arrayRecord(fields) {
  const { at } = fields;
  const type = fields.u8();
  const components = fields.u8();
  const codec = fields.u8();
  check(type >= 1 && type < scalarTypes.length, at, 'A1', `scalar type ${type}`);
  check(components > 0, at, 'A2', 'no components');
  check(codec <= 2, at, 'A3', `codec ${codec}`);
  fields.zeros(5, 'A4');
  const rows = fields.u64();
  const count = Math.ceil(rows / blockRows);
  check(count <= fields.blocks.length - fields.nextBlock, at, 'A5', `${rows} rows have too few blocks`);
  check(rows > 0 || codec === 0, at, 'A6', 'codec of an array of no rows');
  check(codec !== 2 || type === u32Type, at, 'A8', `codec 2 of scalar type ${type}`);
  const rowBytes = components * scalarTypes[type].BYTES_PER_ELEMENT;
  const blocks = fields.blocks.slice(fields.nextBlock, fields.nextBlock + count);
  fields.nextBlock += count;
  blocks.forEach((block, i) => {
    const bytes = Math.min(blockRows, rows - i * blockRows) * rowBytes;
    check(codec !== 0 || block.length === bytes, at, 'A7', `a block of ${block.length} bytes, not ${bytes}`);
    check(bytes <= 1024 * block.length, at, 'A9', `${block.length} bytes for ${bytes}`);
  });
  return { type, components, codec, rows, rowBytes, blocks };
}

/** Puts rows that were transposed, from `content` at `from`, one after another into `to`. */
function toRows(content, from, rowBytes, to) {
  const rows = to.length / rowBytes;
  for (let byte = 0; byte < rowBytes; ++byte) {
    for (let row = 0, place = byte; row < rows; ++row, place += rowBytes) to[place] = content[from++];
  }
}

/** Codec 2: the scalars of one block, from the content of its frame, into `numbers`. */
function toNumbers(content, components, numbers, at) {
  const count = numbers.length;
  const rows = count / components;
  let rest = 0;
  for (let i = 0; i < count; ++i) if (content[i] === 0) ++rest;
  check(content.length === count + 4 * rest, at, 'A15', `${rest} numbers are not repeated`);
  let used = count; // the first byte of the next number that is not repeated
  let before = 0;
  for (let row = 0, i = 0; row < rows; ++row) {
    for (let column = 0; column < components; ++column, ++i) {
      const distance = content[column * rows + row];
      if (distance === 0) {
        const z = content[used] | (content[used + rest] << 8) | (content[used + 2 * rest] << 16)
          | (content[used + 3 * rest] << 24);
        ++used;
        before = (before + ((z >>> 1) ^ -(z & 1))) >>> 0;
        numbers[i] = before;
      } else {
        check(distance <= i, at, 'A14', 'a distance to before the first scalar');
        numbers[i] = numbers[i - distance];
      }
    }
  }
}

/**
 * The scalars of an array, row after row, as a typed array of their type with its own memory.
 * @param record of arrayRecord()
 * @param {number} at the offset of the chunk, for errors
 * @param {string[]} features of HEAD
 */
export function valuesOf(record, at, features) {
  const { type, components, codec, rows, rowBytes, blocks } = record;
  check(codec === 0 || features.includes('zstd'), at, 'A13', 'HEAD does not name the feature zstd');
  const size = rows * rowBytes;
  check(size <= mostBytes, at, 'A9', `not enough memory here for an array of ${size} bytes`);
  const values = new scalarTypes[type](rows * components);
  const bytes = new Uint8Array(values.buffer);
  blocks.forEach((block, i) => {
    const begin = i * blockRows * rowBytes;
    const target = bytes.subarray(begin, Math.min(begin + blockRows * rowBytes, size));
    if (codec === 0) {
      target.set(block);
    } else if (codec === 1) {
      toRows(decompress(block, target.length, target.length, at), 0, rowBytes, target);
    } else {
      const count = target.length / 4;
      toNumbers(decompress(block, count, 5 * count, at), components,
        values.subarray(begin / 4, begin / 4 + count), at);
    }
  });
  return values;
}

/** The bytes of the scalars. */
export const bytesOf = (values) => new Uint8Array(values.buffer, values.byteOffset, values.byteLength);
