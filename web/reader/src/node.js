// Files of Node.
import { closeSync, fstatSync, openSync, readSync } from 'node:fs';
import path from 'node:path';

import { check } from './invalid.js';
import { httpSource } from './source.js';

const tailBytes = 256 * 1024;

/** A source (source.js) of a file on disk, to be closed. */
export function fileSource(file) {
  const descriptor = openSync(file, 'r');
  const { size } = fstatSync(descriptor);
  const readNow = (at, length) => {
    check(at + length <= size, at, 'C3', `${length} bytes, the file has ${size} in all`);
    const bytes = new Uint8Array(length);
    for (let done = 0; done < length;) {
      const more = readSync(descriptor, bytes, done, length - done, at + done);
      check(more > 0, at + done, 'C3', 'the file became shorter');
      done += more;
    }
    source.bytesRead += length;
    return bytes;
  };
  const source = {
    name: path.basename(file), size, bytesRead: 0, requests: 0,
    read: async (at, length) => readNow(at, length),
    beside: async (other) => (/^https?:/i.test(other) ? httpSource(other)
      : fileSource(path.join(path.dirname(file), other))),
    close: () => closeSync(descriptor),
  };
  try {
    const length = Math.min(size, tailBytes);
    source.tail = readNow(size - length, length);
  } catch (error) {
    source.close();
    throw error;
  }
  return source;
}
