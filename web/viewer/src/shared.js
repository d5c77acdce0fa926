// Files that are open in the worker of the page: whatever shows the same file shares one reader, and its slabs.
import { Client } from './client.js';
import { GpuSlab, makeCells } from './gpu.js';

/* global WORKER_CODE */

/** An entry for each file that is open or opening: { users, file: Promise<SharedFile>, from }. */
const entries = new Set();
/** The worker, while a file is open. */
const worker = { client: null };

/**
 * Opens a file, unless it is open.
 * @param {string|Blob|Uint8Array} from its address, or the file
 * @param {string} [name]
 * @returns {Promise<SharedFile>} to be closed by each who opened it
 */
export function openShared(from, name) {
  for (const entry of entries) {
    if (typeof from === 'string' && entry.from === from) {
      ++entry.users;
      return entry.file;
    }
  }
  worker.client ??= new Client(WORKER_CODE);
  const { client } = worker;
  const entry = { users: 1, from };
  entries.add(entry);
  const end = () => {
    entries.delete(entry);
    if (entries.size > 0 || worker.client !== client) return;
    client.end();
    worker.client = null;
  };
  entry.file = client.call('open', { from, name }).then((info) => new SharedFile(client, info, {
    close() {
      if (--entry.users > 0) return;
      client.call('close', { file: info.file });
      end();
    },
    // A later opening gets the file's contents of that time.
    forget() { entry.from = null; },
  }), (error) => {
    end();
    throw error;
  });
  return entry.file;
}

const middleOf = (bodies, pickLow, pickHigh) => {
  const low = Math.min(...bodies.map(pickLow));
  const high = Math.max(...bodies.map(pickHigh));
  return Number.isFinite(low + high) ? (low + high) / 2 : 0;
};

class SharedFile {
  /**
   * @param {Client} client
   * @param info of the worker's open()
   * @param {{close: () => void, forget: () => void}} entry
   */
  constructor(client, info, { close, forget }) {
    Object.assign(this, { client, info, close, forget, read: info.read, requests: info.requests });
    /** Slabs by 'body/slab': { users, slab: Promise<GpuSlab> }. */
    this.slabs = new Map();
    /** Textures of cells, by connectivity. */
    this.cells = new Map();
    /** Slabs on the GPU are relative to this. */
    this.center = [
      ...[0, 1, 2].map((i) => middleOf(info.bodies, ({ min }) => min[i], ({ max }) => max[i])),
      middleOf(info.bodies, ({ begin }) => begin, ({ end }) => end),
    ];
  }

  call(call, args) {
    return this.client.call(call, { file: this.info.file, ...args });
  }

  /** A slab, to be released by each who takes it. */
  take(body, number) {
    const key = `${body}/${number}`;
    let entry = this.slabs.get(key);
    if (!entry) {
      entry = { users: 0, slab: this.fetch(body, number) };
      this.slabs.set(key, entry);
      entry.slab.catch(() => {
        this.slabs.delete(key);
        this.forget();
      });
    }
    ++entry.users;
    return entry.slab;
  }

  async fetch(body, number) {
    const slab = await this.call('slab', { body, slab: number });
    Object.assign(this, { read: slab.read, requests: slab.requests });
    if (slab.cells) this.cells.set(slab.connectivity, makeCells(slab));
    const cells = this.cells.get(slab.connectivity);
    if (cells) return new GpuSlab(slab, cells, this.center);
    // They were forgotten while this was on its way.
    await this.call('forget', { connectivity: slab.connectivity });
    return this.fetch(body, number);
  }

  /** A slab that was taken is not needed any more. */
  release(body, number) {
    const key = `${body}/${number}`;
    const entry = this.slabs.get(key);
    if (!entry) return;
    --entry.users;
    entry.slab.then((slab) => {
      // This disposes the slab of all renderers; those that still show it upload it again.
      slab.dispose();
      if (entry.users > 0 || this.slabs.get(key) !== entry) return;
      this.slabs.delete(key);
      if (--slab.cells.users > 0) return;
      this.cells.delete(slab.connectivity);
      this.call('forget', { connectivity: slab.connectivity });
    }, () => {});
  }

  /** Asks for the values of an attribute of a slab, once. */
  attribute(gpu, body, number, name) {
    if (!gpu.asked.has(name)) {
      gpu.asked.set(name, this.call('attribute', { body, slab: number, name })
        .then((values) => gpu.setAttribute(name, values)));
    }
    return gpu.asked.get(name);
  }
}
