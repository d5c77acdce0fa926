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
    URL.revokeObjectURL(url);
    this.pending = new Map();
    this.next = 0;
    this.worker.onmessage = ({ data: { id, part, value, error } }) => {
      const { resolve, reject, onPart } = this.pending.get(id);
      if (part) {
        onPart(part);
        return;
      }
      this.pending.delete(id);
      if (error) reject(new FileError(error));
      else resolve(value);
    };
    this.worker.onerror = (event) => {
      for (const { reject } of this.pending.values()) reject(new Error(event.message));
      this.pending.clear();
    };
  }

  /** Ends the worker; calls are not answered any more. */
  end() {
    this.worker.terminate();
    this.pending.clear();
  }

  /** The answer of a call, as a promise. */
  call(call, args) {
    return this.begin(call, args).answer;
  }

  /**
   * A call whose answer comes in parts, and that can be stopped.
   * @param {(part: any) => void} onPart called for each part that comes before the answer
   * @returns {{answer: Promise<any>, stop: () => void}} of a call that was stopped, the answer is null
   */
  begin(call, args, onPart) {
    const id = this.next++;
    const answer = new Promise((resolve, reject) => {
      this.pending.set(id, { resolve, reject, onPart });
      this.worker.postMessage({ id, call, args });
    });
    return { answer, stop: () => this.pending.has(id) && this.worker.postMessage({ id, stop: true }) };
  }
}
