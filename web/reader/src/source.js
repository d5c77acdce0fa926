// Sources of the bytes of a file. A source has
//   size: number                                 of the file, in bytes
//   tail: Uint8Array                             the last bytes, as far as read when it was opened
//   read(at, length): Promise<Uint8Array>        fails where they are not all there
//   name: string
//   bytesRead, requests: number
//   beside?(path): Promise<source>               of a file by its path from the folder of this one, or its URL
import { check } from './invalid.js';

/** Size of the first request; it holds the index of all but large files. */
const tailBytes = 256 * 1024;

/** Servers that know no ranges send the whole file; up to this size it is taken. */
const largestWhole = 256 * 1024 * 1024;

/** @param {Uint8Array} bytes of a file in memory */
export function bytesSource(bytes, name = 'file') {
  return {
    name, size: bytes.length, tail: bytes, bytesRead: bytes.length, requests: 0,
    async read(at, length) {
      check(at + length <= bytes.length, at, 'C3', `${length} bytes, the file has ${bytes.length} in all`);
      return bytes.subarray(at, at + length);
    },
  };
}

/** @param {Blob} blob such as a File that was dropped onto a page */
export async function blobSource(blob, name = blob.name ?? 'file') {
  const slice = async (at, end) => new Uint8Array(await blob.slice(at, end).arrayBuffer());
  const tail = await slice(Math.max(0, blob.size - tailBytes), blob.size);
  const source = {
    name, size: blob.size, tail, bytesRead: tail.length, requests: 0,
    async read(at, length) {
      check(at + length <= blob.size, at, 'C3', `${length} bytes, the file has ${blob.size} in all`);
      source.bytesRead += length;
      return slice(at, at + length);
    },
  };
  return source;
}

/** Something that keeps a file from being fetched. */
export class FetchError extends Error {
  constructor(message) {
    super(message);
    this.name = 'FetchError';
  }
}

/**
 * A file on a web server that answers range requests. All requests are for the version of the file that
 * the first one found, by its ETag where the server has one.
 * @param {string|URL} url
 * @param {{fetch?: typeof fetch}} [options]
 */
export async function httpSource(url, { fetch = globalThis.fetch } = {}) {
  const name = decodeURIComponent(new URL(url, globalThis.location?.href).pathname.split('/').at(-1));
  const beside = (path) => httpSource(new URL(path, new URL(url, globalThis.location?.href)), { fetch });
  const source = { name, size: 0, tail: null, bytesRead: 0, requests: 0, read: null, beside };
  const request = async (range, headers = {}) => {
    ++source.requests;
    let response;
    try {
      response = await fetch(url, { headers: { Range: `bytes=${range}`, ...headers } });
    } catch (error) {
      throw new FetchError(`${name}: cannot be fetched: ${error.message}; the server may be down, `
        + 'or may not allow pages of other sites to read it (CORS)');
    }
    return response;
  };
  const bodyOf = async (response) => {
    const bytes = new Uint8Array(await response.arrayBuffer());
    source.bytesRead += bytes.length;
    return bytes;
  };

  const first = await request(`-${tailBytes}`);
  if (first.status === 200) {
    const length = Number(first.headers.get('Content-Length') ?? 0);
    if (length > largestWhole) {
      await first.body?.cancel();
      throw new FetchError(`${name}: the server answers no range requests, and the file has ${length} bytes: `
        + 'use another server, or download the file');
    }
    return Object.assign(source, bytesSource(await bodyOf(first), name), { requests: 1 });
  }
  if (first.status !== 206) throw new FetchError(`${name}: the server answers ${first.status} ${first.statusText}`);
  const etag = first.headers.get('ETag');
  source.tail = await bodyOf(first);
  // Servers of other sites may not show this header; then the footer says the size.
  const total = /\/(\d+)$/.exec(first.headers.get('Content-Range') ?? '')?.[1];
  source.size = total ? Number(total) : NaN;
  const version = etag && !etag.startsWith('W/') ? { 'If-Match': etag } : {};
  source.read = async (at, length) => {
    check(!(at + length > source.size), at, 'C3', `${length} bytes, the file has ${source.size} in all`);
    const tailAt = source.size - source.tail.length;
    if (at >= tailAt) return source.tail.subarray(at - tailAt, at - tailAt + length);
    const response = await request(`${at}-${at + length - 1}`, version);
    if (response.status === 412 || response.status === 200) {
      await response.body?.cancel();
      throw new FetchError(`${name}: the file has changed on the server; open it again`);
    }
    if (response.status !== 206) {
      throw new FetchError(`${name}: the server answers ${response.status} ${response.statusText}`);
    }
    const bytes = await bodyOf(response);
    if (bytes.length !== length) {
      throw new FetchError(`${name}: ${bytes.length} bytes came instead of ${length}`);
    }
    return bytes;
  };
  return source;
}
