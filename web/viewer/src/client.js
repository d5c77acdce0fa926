// Calls of the worker, as promises.

/** An error of the file, with place and rule where it breaks one. */
export class FileError extends Error {
  constructor({ message, at, rule, isKnown, stack }) {
    super(message);
    Object.assign(this, { at, rule, isKnown, workerStack: stack });
  }
}

export class Client {
  /** @param {string} code of the worker */
  constructor(code) {
    const url = URL.createObjectURL(new Blob([code], { type: 'text/javascript' }));
    this.worker = new Worker(url);
    this.pending = new Map();
    this.next = 0;
    this.worker.onmessage = ({ data: { id, value, error } }) => {
      const { resolve, reject } = this.pending.get(id);
      this.pending.delete(id);
      if (error) reject(new FileError(error));
      else resolve(value);
    };
    this.worker.onerror = (event) => {
      for (const { reject } of this.pending.values()) reject(new Error(event.message));
      this.pending.clear();
    };
  }

  call(call, args) {
    const id = this.next++;
    return new Promise((resolve, reject) => {
      this.pending.set(id, { resolve, reject });
      this.worker.postMessage({ id, call, args });
    });
  }
}
