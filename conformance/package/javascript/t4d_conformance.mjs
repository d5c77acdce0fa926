#!/usr/bin/env node
// Runs any reader of .t4d files against the corpus, without t4d:
//
//     t4d-conformance --reader './my-reader' [--junit FILE] [--badge FILE]
//
// The reader serves, as the appendix "A reader under test" of the specification of .t4d defines: it takes requests such
// as `describe FILE` from standard input and answers each with a line `accept JSON` or `refuse WHY`. Exits with 0 if
// every case passed, 1 if one failed, 2 for wrong usage. One file, Node 18 or later, no other package; public
// domain (CC0 1.0).
import { spawn } from "node:child_process";
import { closeSync, mkdtempSync, openSync, readFileSync, realpathSync, rmSync, writeFileSync } from "node:fs";
import os from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";

const TEXTS = new Set(["name", "domain", "version", "features"]); // and checksums: all else is a number
const DECIMAL = /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i;
const HEXADECIMAL = /^([+-]?)0x([0-9a-f]+)\.?([0-9a-f]*)(?:p([+-]?\d+))?$/i;
const MOST_BYTES = 16 * 2 ** 20; // of an answer

// What must be answered ----------------------------------------------------------------------------

/** The number that C's strtod reads, or undefined. */
function number(text) {
  if (typeof text !== "string") return undefined;
  if (DECIMAL.test(text)) return Number(text);
  const found = HEXADECIMAL.exec(text);
  if (!found) return { inf: Infinity, "-inf": -Infinity, nan: NaN }[text.toLowerCase()];
  const [, sign, whole, fraction, exponent] = found;
  // At most 53 bits are set, so the division is exact; two factors, for 2^-1074 times 2^52 is no factor.
  let value = Number(BigInt(`0x${whole}${fraction}`)), power = Number(exponent ?? 0) - 4 * fraction.length;
  for (; power > 1000; power -= 1000) value *= 2 ** 1000;
  for (; power < -1000; power += 1000) value *= 2 ** -1000;
  return (sign === "-" ? -1 : 1) * value * 2 ** power;
}

const isObject = (value) => typeof value === "object" && value !== null && !Array.isArray(value);

/** The first place where the answer differs, or undefined. `within` has tolerances, as in NAME.json. */
function difference(expected, actual, within, path = "") {
  if (isObject(expected)) {
    if (!isObject(actual)) return `${path || "the answer"} is not an object`;
    for (const [key, value] of Object.entries(expected)) {
      const place = path ? `${path}.${key}` : key;
      let inner = within, found;
      if (isObject(within)) inner = within[key] ?? (key === "min" || key === "max" ? within.length : undefined);
      if (!Object.hasOwn(actual, key)) return `${place} is missing`;
      if (TEXTS.has(key) || key.endsWith("checksum")) {
        if (JSON.stringify(actual[key]) !== JSON.stringify(value)) {
          found = `${place} is ${JSON.stringify(actual[key])}, not ${JSON.stringify(value)}`;
        }
      } else {
        found = difference(value, actual[key], inner, place);
      }
      if (found) return found;
    }
    return undefined;
  }
  if (Array.isArray(expected)) {
    if (!Array.isArray(actual) || actual.length !== expected.length) return `${path} has not ${expected.length} entries`;
    for (let i = 0; i < expected.length; ++i) {
      const inner = path === "bodies" && Array.isArray(within) ? within[i] : within;
      const found = difference(expected[i], actual[i], inner, `${path}[${i}]`);
      if (found) return found;
    }
    return undefined;
  }
  if (expected === null) return actual === null ? undefined : `${path} is not null`;
  const given = number(actual);
  if (given === undefined) return `${path} is ${JSON.stringify(actual)}, which is no number`;
  const allowed = typeof within === "string" ? number(within) : 0;
  return Math.abs(given - number(expected)) <= allowed ? undefined : `${path} is ${actual}, not ${expected}`;
}

/** The fault of the reader's answer, or undefined. */
function faultOf({ result, answer }, verdict, text) {
  if (verdict === "refuse") return result === "valid" ? `refused a valid file: ${text.slice(0, 200)}` : undefined;
  if (result === "invalid") return "accepted, but must be refused";
  try {
    return difference(answer.answer, JSON.parse(text), answer.within);
  } catch (error) {
    return `accepted, and the answer is no JSON: ${error.message}`;
  }
}

const WORD = 2n ** 64n;

/** The byte of pseudo-random garbage at this place (splitmix64). */
function noise(place) {
  let z = (BigInt(place) + 0x9e3779b97f4a7c15n) % WORD;
  z = ((z ^ (z >> 30n)) * 0xbf58476d1ce4e5b9n) % WORD;
  z = ((z ^ (z >> 27n)) * 0x94d049bb133111ebn) % WORD;
  return Number((z ^ (z >> 31n)) & 0xffn);
}

function damaged(bytes, damage) {
  if ("cut" in damage) return bytes.subarray(0, damage.cut);
  const data = Buffer.from(bytes);
  if ("flip" in damage) data[damage.flip[0]] ^= 1 << damage.flip[1];
  for (const [begin, size] of damage.overwrite ?? []) {
    for (let at = begin; at < begin + size; ++at) data[at] = damage.with === "ones" ? 0xff : noise(at);
  }
  return data;
}

/** {id, file, trials} of every case: valid files, the simplest first, then the others, then damaged ones. */
export function cases(corpus, without = []) {
  const load = (name) => JSON.parse(readFileSync(join(corpus, name), "utf8"));
  const rank = { valid: 0, either: 1, invalid: 2 };
  const entries = load("manifest.json").files;
  entries.sort((a, b) => rank[a.result] - rank[b.result] || (a.result !== "valid" ? 0
    : a.features.length - b.features.length || a.bytes - b.bytes));
  const answers = new Map(), unknown = new Set(), made = [];
  for (const entry of entries) {
    const { id, file, result } = entry;
    let trials = ["describe", ...(entry.refused_slices ?? []).map((time) => `slice ${time}`)]
      .map((request) => ({ request, result }));
    if (entry.expected) {
      const known = load(entry.expected);
      const slices = known.slices.map((answer) => ({ request: `slice ${answer.time}`, result, answer }));
      const sections = known.sections.map((answer) => ({ request: `slice ${answer.by}`, result, answer }));
      answers.set(file, new Map(slices.map((trial) => [trial.request, trial.answer])));
      trials = [{ request: "describe", result, answer: known.describe }, ...slices,
        ...(without.includes("hyperplanes") ? [] : sections)];
      if (known.describe.answer.features.some((feature) => without.includes(feature))) {
        unknown.add(file);
        trials = [{ request: "describe", result: "invalid" }];
      }
    }
    made.push({ id, file, trials });
  }
  for (const { id, file, trials } of load("damaged.json").cases) {
    if (unknown.has(file)) continue;
    made.push({ id, file, trials: trials.map((damage) => "overwrite" in damage && damage.request !== "describe"
      ? { request: damage.request, result: "valid", answer: answers.get(file).get(damage.request), damage }
      : { request: damage.request, result: "invalid", damage }) });
  }
  return made;
}

// The reader ---------------------------------------------------------------------------------------

/** A serving reader, restarted after anything that is not an answer. */
class Reader {
  constructor(command, seconds, folder) {
    Object.assign(this, { command, seconds, errors: join(folder, "errors"), process: undefined });
  }

  start() {
    const log = openSync(this.errors, "w");
    const [program, ...options] = this.command;
    const process = spawn(program, [...options, "--serve"], { stdio: ["pipe", "pipe", log] });
    closeSync(log);
    Object.assign(this, { process, left: [], bytes: 0, ended: undefined, changed: () => {} });
    process.stdout.on("data", (data) => { this.left.push(data); this.bytes += data.length; this.changed(data); });
    process.stdin.on("error", () => {}); // It has ended, which is found below.
    const end = (code, signal) => { this.ended ??= `exit code ${code ?? signal}`; this.changed(); };
    process.on("error", (error) => end(error.message));
    process.on("close", end);
  }

  /** [verdict, text]: "accept" or "refuse", or "crashed" or "timed out" with the reason. */
  async ask(request, path) {
    if (!this.process) this.start();
    const line = new Promise((resolve) => {
      const timer = setTimeout(() => resolve(["timed out", `no answer within ${this.seconds} s`]), 1000 * this.seconds);
      this.changed = (data) => {
        if (data?.includes(10)) resolve(undefined);
        else if (this.ended) resolve(["crashed", "ended instead of answering"]);
        else if (this.bytes > MOST_BYTES) resolve(["crashed", "16 MiB without a line end"]);
        else return;
        clearTimeout(timer);
      };
    });
    if (this.ended) this.changed();
    this.process.stdin.write(`${request} ${path}\n`);
    const [verdict, why] = (await line) ?? [];
    if (verdict) return [verdict, await this.end(why)];
    const found = Buffer.concat(this.left), at = found.indexOf(10);
    this.left = [found.subarray(at + 1)];
    this.bytes = found.length - at - 1;
    const text = found.toString("utf8", 0, at), word = text.split(" ", 1)[0];
    if (word === "accept" || word === "refuse") return [word, text.slice(word.length + 1)];
    return ["crashed", await this.end(`answered ${JSON.stringify(text.slice(0, 80))}`)];
  }

  /** What it did after its last answer, though it was not asked; or undefined. */
  async lateFault() {
    await new Promise(setImmediate);
    return this.process && (this.bytes || this.ended) ? this.end("wrote or ended after its answer") : undefined;
  }

  async end(why = "") {
    const process = this.process;
    if (!process) return why;
    this.process = undefined;
    process.kill("SIGKILL");
    if (!this.ended) await new Promise((resolve) => { this.changed = () => this.ended && resolve(); });
    const said = readFileSync(this.errors, "utf8").slice(-300).trim();
    return `${why} (${this.ended})${said ? `: ${said}` : ""}`;
  }
}

/** A map of the outcomes [[outcome, message]] of the cases; none where the case passed. */
export async function run(corpus, command, chosen, { jobs = 1, seconds = 60, first = false } = {}) {
  const results = new Map(chosen.map(({ id }) => [id, []]));
  const slow = []; // A reader that waits for ever is asked some times more, not thousands of times.
  let next = 0, found = false;
  const blame = (id, outcome, message) => { results.get(id).push([outcome, message]); found = true; };
  const work = async (folder) => {
    const reader = new Reader(command, seconds, folder), path = join(folder, "file.t4d");
    let last;
    const late = async () => {
      const fault = last && await reader.lateFault();
      if (fault) blame(last, "crashed", fault);
    };
    while (next < chosen.length && slow.length <= 20 && !(first && found)) {
      const { id, file, trials } = chosen[next++];
      const bytes = readFileSync(join(corpus, file));
      for (const trial of trials) {
        await late();
        writeFileSync(path, trial.damage ? damaged(bytes, trial.damage) : bytes);
        last = id;
        const [verdict, text] = await reader.ask(trial.request, path);
        const about = trial.request + (trial.damage ? `, ${JSON.stringify(trial.damage).slice(0, 80)}` : "");
        if (verdict !== "accept" && verdict !== "refuse") {
          blame(id, verdict, `${about}: ${text}`);
          if (verdict === "timed out" && slow.push(id) && slow.filter((each) => each === id).length > 1) break;
        } else {
          const fault = faultOf(trial, verdict, text);
          if (!fault) continue;
          blame(id, "failed", `${about}: ${fault}`);
          await reader.end(); // What it keeps from this request is not to mislead the next.
        }
      }
    }
    await late();
    await reader.end();
  };
  const folders = Array.from({ length: jobs }, () => mkdtempSync(join(os.tmpdir(), "t4d-conformance-")));
  try {
    await Promise.all(folders.map(work));
  } finally {
    for (const folder of folders) rmSync(folder, { recursive: true });
  }
  return results;
}

// Reports ------------------------------------------------------------------------------------------

const escaped = (text) => text.replace(/[^ -~]/g, "?")
  .replace(/[&<>"]/g, (each) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[each]);

export function junit(results) {
  const failed = [...results.values()].filter((wrong) => wrong.length).length;
  return `<?xml version="1.0" encoding="UTF-8"?>
<testsuite name="t4d-conformance" tests="${results.size}" failures="${failed}">
${[...results].map(([id, [wrong]]) => `<testcase classname="${id.split("/")[0]}" name="${escaped(id.split("/")[1])}">${
    wrong ? `<failure message="${escaped(wrong[1])}"/>` : ""}</testcase>`).join("\n")}
</testsuite>
`;
}

export function badge(results, version) {
  const passed = [...results.values()].filter((wrong) => !wrong.length).length;
  const text = `${passed} of ${results.size}`, left = `.t4d corpus ${version}`, right = 8 * text.length + 10;
  const color = passed === results.size ? "#2e7d32" : "#c62828";
  return `<svg xmlns="http://www.w3.org/2000/svg" width="${130 + right}" height="20" role="img" `
    + `aria-label="${left}: ${text}"><rect width="130" height="20" fill="#444"/><rect x="130" width="${right}" `
    + `height="20" fill="${color}"/><g fill="#fff" text-anchor="middle" font-family="sans-serif" font-size="11">`
    + `<text x="65" y="14">${left}</text><text x="${130 + right / 2}" y="14">${text}</text></g></svg>\n`;
}

const USAGE = `Usage: t4d-conformance --reader COMMAND [OPTION...]
Runs a serving reader of .t4d files against the corpus.
  --reader COMMAND   is started with --serve
  --corpus FOLDER    another corpus
  --only GLOB        run only these cases; repeatable
  --without NAMES    what the reader lacks, with commas: zstd, means, pose, grid, hyperplanes
  --junit FILE       write a report for CI
  --badge FILE       write a picture for a README (SVG)
  --json             print the outcome of each case as JSON
  --first            stop at the first fault
  --timeout SECONDS  per request (60)
  --parallel N       readers at a time`;

/** The words of a command, of which quotes keep spaces. */
const wordsOf = (command) => [...command.matchAll(/(?:"[^"]*"|'[^']*'|\\.|[^\s"'\\])+/g)]
  .map(([word]) => word.replace(/"([^"]*)"|'([^']*)'|\\(.)/g, (_, a, b, c) => a ?? b ?? c));

export async function main(args) {
  const text = { type: "string" };
  let options;
  try {
    options = parseArgs({ args, options: { reader: text, corpus: text, only: { ...text, multiple: true }, without: text,
      junit: text, badge: text, json: { type: "boolean" }, first: { type: "boolean" }, timeout: text, parallel: text,
      help: { type: "boolean" } } }).values;
  } catch (error) {
    console.error(`${error.message}\n${USAGE}`);
    return 2;
  }
  if (options.help || !options.reader) {
    (options.help ? console.log : console.error)(USAGE);
    return options.help ? 0 : 2;
  }
  const corpus = options.corpus ?? join(fileURLToPath(import.meta.url), "../corpus");
  const version = readFileSync(join(corpus, "VERSION"), "utf8").split(/\s/)[1];
  const globs = (options.only ?? []).map((glob) => new RegExp(`^(?:[^/]*/)?${glob.replace(/[.+^${}()|\\]/g, "\\$&")
    .replace(/\*/g, ".*").replace(/\?/g, ".")}(?:/.*)?$`));
  const chosen = cases(corpus, options.without?.split(",")).filter(
    ({ id }) => !globs.length || globs.some((glob) => glob.test(id)));
  if (!chosen.length) {
    console.error("no case has such a name");
    return 2;
  }
  const jobs = Number(options.parallel ?? (os.availableParallelism?.() ?? os.cpus().length));
  const results = await run(corpus, wordsOf(options.reader), chosen,
    { jobs, seconds: Number(options.timeout ?? 60), first: options.first });
  if (options.junit) writeFileSync(options.junit, junit(results));
  if (options.badge) writeFileSync(options.badge, badge(results, version));
  const wrong = [...results].filter(([, found]) => found.length);
  if (options.json) {
    console.log(JSON.stringify({ corpus_version: version,
      cases: [...results].map(([id, [found]]) => ({ id, outcome: found?.[0] ?? "passed" })) }));
  } else {
    for (const [id, found] of wrong.slice(0, 20)) {
      const more = found.length > 1 ? `; and ${found.length - 1} more` : "";
      console.log(`${found[0][0]} ${id}\n  ${found[0][1]}${more}`);
    }
    console.log(`${results.size - wrong.length} passed, ${wrong.length} failed (corpus ${version})`);
  }
  return wrong.length ? 1 : 0;
}

// npm starts it by a link.
if (process.argv[1] && fileURLToPath(import.meta.url) === realpathSync(process.argv[1])) {
  process.exitCode = await main(process.argv.slice(2));
}
