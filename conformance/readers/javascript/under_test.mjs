// What a reader under test (the appendix of formats/t4d/SPEC.md) is called with, and what it answers:
//
//     READER FILE describe | FILE slice T | FILE slice x|y|z C | FILE slice A,B,C,D E
//     READER --serve           answers such requests from standard input, one a line
//
// Exits with 0, or 1 if the file is refused, which standard error says why, or 2 for wrong usage. A mistake of the
// reader exits with 70: Node's own 1 would look like a refusal.
import { createInterface } from 'node:readline';

const units = { x: [1, 0, 0, 0], y: [0, 1, 0, 0], z: [0, 0, 1, 0] };

/** { verb, normal, offset }, or null. */
function requestOf([verb, ...rest]) {
  if (verb === 'describe' && rest.length === 0) return { verb };
  if (verb !== 'slice' || rest.length < 1 || rest.length > 2) return null;
  const numberOf = (word) => (word.trim() ? Number(word) : NaN);
  const normal = rest.length === 1 ? [0, 0, 0, 1] : units[rest[0]] ?? rest[0].split(',').map(numberOf);
  const offset = numberOf(rest.at(-1));
  const isKnown = normal.length === 4 && normal.some((value) => value !== 0) &&
    [...normal, offset].every(Number.isFinite);
  return isKnown ? { verb, normal, offset } : null;
}

/** { answer }, { refusal } or { mistake }. */
async function respond(reader, path, { verb, normal, offset }) {
  let file;
  try {
    file = reader.open(path);
    return { answer: verb === 'slice' ? await reader.slice(file, normal, offset) : await reader.describe(file) };
  } catch (error) {
    const isRefusal = error instanceof reader.Invalid || error.syscall !== undefined;
    return isRefusal ? { refusal: `${path}: ${error.message}` } : { mistake: error };
  } finally {
    file?.close();
  }
}

/** Answers requests line by line, such as "describe FILE" and "slice T FILE". */
async function serve(reader) {
  for await (const line of createInterface({ input: process.stdin, crlfDelay: Infinity })) {
    const form = /^(describe|slice (?:[xyz]|\S*,\S*) \S+|slice \S+) (.*)$/;
    const [, words = '', path] = form.exec(line) ?? [];
    const request = requestOf(words.split(' '));
    const { answer, refusal, mistake } =
      request ? await respond(reader, path, request) : { mistake: `not a request: ${line}` };
    if (mistake) {
      console.error(mistake);
      return 70;
    }
    process.stdout.write(answer
      ? `accept ${JSON.stringify(answer)}\n` : `refuse ${refusal.replaceAll('\n', ' ')}\n`);
  }
  return 0;
}

/**
 * Runs a reader with the arguments of the process; returns the exit code.
 * @param {{open(path: string): {close(): void}, describe(file), slice(file, normal: number[], offset: number),
 *   Invalid: Function}} reader Invalid is the class of errors that refuse a file
 */
export async function run(reader) {
  const [path, ...words] = process.argv.slice(2);
  if (path === '--serve' && words.length === 0) return serve(reader);
  const request = requestOf(words);
  if (!request) {
    console.error('usage: FILE describe | FILE slice T | FILE slice x|y|z C | FILE slice A,B,C,D E | --serve');
    return 2;
  }
  const { answer, refusal, mistake } = await respond(reader, path, request);
  if (!answer) {
    console.error(refusal ?? mistake);
    return refusal ? 1 : 70;
  }
  process.stdout.write(`${JSON.stringify(answer, null, 1)}\n`);
  return 0;
}
