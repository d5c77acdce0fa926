import { ZSTDDecoder } from 'zstddec';

import { check } from './invalid.js';

const decoder = new ZSTDDecoder();
let ready = null;

/** Loads the decompressor; to be awaited before decompress() is called. */
export function prepareZstd() {
  ready ??= decoder.init();
  return ready;
}

/**
 * The content size of a Zstandard frame that is whole and alone (A10, A11), which decompressors do not
 * tell: they take skippable frames and several of them as well (RFC 8878, section 3.1.1).
 */
function contentSizeOf(frame, at) {
  const isFrame = (ok) => check(ok, at, 'A10', 'not one Zstandard frame, whole and alone');
  const view = new DataView(frame.buffer, frame.byteOffset, frame.byteLength);
  isFrame(frame.length >= 6 && view.getUint32(0, true) === 0xfd2fb528);
  const descriptor = frame[4];
  const isSingleSegment = (descriptor >> 5) & 1;
  const dictionaryBytes = [0, 1, 2, 4][descriptor & 3];
  const sizeBytes = [isSingleSegment, 2, 4, 8][descriptor >> 6];
  const checksumBytes = descriptor & 4;
  let place = 5 + (isSingleSegment ? 0 : 1);
  isFrame((descriptor & 8) === 0 && place + dictionaryBytes + sizeBytes <= frame.length);
  for (let i = 0; i < dictionaryBytes; ++i) isFrame(frame[place++] === 0);
  let size = 0;
  for (let i = sizeBytes - 1; i >= 0; --i) size = size * 256 + frame[place + i];
  if (sizeBytes === 2) size += 256;
  place += sizeBytes;
  for (let isLast = false; !isLast;) {
    isFrame(place + 3 <= frame.length);
    const header = frame[place] | (frame[place + 1] << 8) | (frame[place + 2] << 16);
    isLast = (header & 1) === 1;
    const type = (header >> 1) & 3;
    isFrame(type < 3);
    place += 3 + (type === 1 ? 1 : header >> 3);
  }
  isFrame(place + checksumBytes === frame.length);
  check(sizeBytes > 0, at, 'A11', 'the frame declares no content size');
  return size;
}

/**
 * The content of a frame, which has to have `least` to `most` bytes.
 * @param {Uint8Array} frame
 * @param {number} at the offset of the chunk, for errors
 */
export function decompress(frame, least, most, at) {
  const size = contentSizeOf(frame, at);
  check(size >= least && size <= most, at, 'A11', () =>
    `a frame of ${size} bytes, expected ${least === most ? most : `${least} to ${most}`}`);
  const content = decoder.decode(frame, size);
  check(content.length === size, at, 'A12', 'the frame does not decompress');
  return content;
}
