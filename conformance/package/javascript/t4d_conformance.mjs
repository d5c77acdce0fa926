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

const TEXTS = ["name", "domain", "version", "features"]; // and checksums: all else that is a string is a number
const HEXADECIMAL = /^([+-]?)0x([0-9a-f]+)\.?([0-9a-f]*)(?:p([+-]?\d+))?$/i;
const MOST_BYTES = 16 * 2 ** 20; // of an answer

/** The number that C's strtod reads, or NaN. */
function number(text) {
  const [, sign, whole, fraction, exponent] = HEXADECIMAL.exec(text) ?? [];
  if (typeof text !== "string") return NaN;
  if (!whole) return /^[+-]?[\d.]+(e[+-]?\d+)?$/i.test(text) ? Number(text) : NaN;
  // At most 53 bits are set, so the first product is exact; two factors, for 2^-1074 times 2^52 is no factor.
  const power = Number(exponent ?? 0) - 4 * fraction.length, half = Math.trunc(power / 2);
  return Number(`${sign}1`) * Number(BigInt(`0x${whole}${fraction}`)) * 2 ** half * 2 ** (power - half);
}

/** The first place where the answer differs, or undefined. `within` has tolerances, as in NAME.json. */
function difference(expected, actual, within, key = "", place = "the answer") {
  const isExact = TEXTS.includes(key) || key.endsWith("checksum");
  if (typeof expected === "string" && !isExact) {
    if (Math.abs(number(actual) - number(expected)) <= number(within ?? "0")) return undefined;
  } else if (isExact || !expected || !actual || Array.isArray(expected) !== Array.isArray(actual)
      || expected.length !== actual.length) {
    if (JSON.stringify(actual) === JSON.stringify(expected)) return undefined;
  } else {
    for (const [name, value] of Object.entries(expected)) {
      const isList = Array.isArray(expected);
      const inner = isList !== Array.isArray(within) ? within
        : within?.[name === "min" || name === "max" ? "length" : name];
      const found = difference(value, actual[name], inner, isList ? "" : name, `${place}.${name}`);
      if (found) return found;
    }
    return undefined;
  }
  return `${place} is ${JSON.stringify(actual)?.slice(0, 80)}, not ${JSON.stringify(expected).slice(0, 80)}`;
}

/** What is wrong with the reader's answer, or undefined. */
function faultOf({ result, answer }, verdict, text) {
  if (verdict === "refuse") return result === "valid" ? `refused a valid file: ${text.slice(0, 200)}` : undefined;
  if (result === "invalid") return "accepted, but must be refused";
  try {
    return difference(answer.answer, JSON.parse(text), answer.within);
  } catch (error) {
    return `accepted, and the answer is no JSON: ${error.message}`;
  }
}

/** The byte of pseudo-random garbage at this place (splitmix64). */
function noise(place) {
  let z = BigInt.asUintN(64, BigInt(place) + 0x9e3779b97f4a7c15n);
  z = BigInt.asUintN(64, (z ^ (z >> 30n)) * 0xbf58476d1ce4e5b9n);
  z = BigInt.asUintN(64, (z ^ (z >> 27n)) * 0x94d049bb133111ebn);
  return Number((z ^ (z >> 31n)) & 0xffn);
}

function damaged(bytes, damage) {
  const data = Buffer.from(bytes.subarray(0, damage.cut));
  if (damage.flip) data[damage.flip[0]] ^= 1 << damage.flip[1];
  for (const [begin, size] of damage.overwrite ?? []) {
    for (let at = begin; at < begin + size; ++at) data[at] = damage.with === "ones" ? 0xff : noise(at);
  }
  return data;
}

/** {id, file, trials} of every case: valid files, the simplest first, then the others, then damaged ones. */
export function cases(corpus, without = []) {
  const load = (name) => JSON.parse(readFileSync(join(corpus, name), "utf8"));
  const rank = ({ result, features, bytes }) => (result === "valid" ? 1e12 * features.length + bytes : 1e15);
  const slices = new Map(); // answers by request, of each file that the reader knows
  const made = load("manifest.json").files.sort((a, b) => rank(a) - rank(b)).map((entry) => {
    let { result } = entry, requests = [["describe"], ...(entry.refused_slices ?? []).map((at) => [`slice ${at}`])];
    const known = entry.expected && load(entry.expected);
    if (known?.describe.answer.features.some((feature) => without.includes(feature))) {
      [result, requests] = ["invalid", [["describe"]]];
    } else if (known) {
      slices.set(entry.file, new Map(known.slices.map((answer) => [`slice ${answer.time}`, answer])));
      requests = [["describe", known.describe], ...slices.get(entry.file)];
      const sections = without.includes("hyperplanes") ? [] : known.sections;
      requests.push(...sections.map((answer) => [`slice ${answer.by}`, answer]));
    }
    return { ...entry, trials: requests.map(([request, answer]) => ({ request, result, answer })) };
  });
  const copies = load("damaged.json").cases.filter(({ file }) => slices.has(file));
  return [...made, ...copies.map(({ id, file, trials }) => ({ id, file, trials: trials.map((damage) => {
    // A slice needs nothing of what is overwritten.
    const answer = damage.overwrite && slices.get(file).get(damage.request);
    return { request: damage.request, result: answer ? "valid" : "invalid", answer, damage };
  }) }))];
}

/** A serving reader, started again after whatever is no answer. */
class Reader {
  constructor(command, seconds, errors) {
    Object.assign(this, { command, seconds, errors });
  }

  start() {
    const log = openSync(this.errors, "w");
    this.process = spawn(`exec ${this.command} --serve`, { shell: true, stdio: ["pipe", "pipe", log] });
    closeSync(log);
    Object.assign(this, { left: "", ended: undefined, changed: () => {} });
    this.process.on("close", (code, signal) => { this.ended = `exit code ${code ?? signal}`; this.changed(); });
    this.process.stdout.setEncoding("utf8").on("data", (text) => { this.left += text; this.changed(); });
    this.process.stdin.on("error", () => {}); // It has ended, which is found below.
  }

  /** Until something has changed. */
  change() {
    return new Promise((resolve) => { this.changed = resolve; });
  }

  /** [verdict, text]: "accept" or "refuse", or "crashed" or "timed out" with the reason. */
  async ask(request, path) {
    if (!this.process) this.start();
    this.process.stdin.write(`${request} ${path}\n`);
    let isLate = false;
    const timer = setTimeout(() => { isLate = true; this.changed(); }, 1000 * this.seconds);
    const isWaiting = () => !this.left.includes("\n") && this.left.length <= MOST_BYTES && !this.ended && !isLate;
    while (isWaiting()) await this.change();
    clearTimeout(timer);
    const [, verdict, text] = /^(accept|refuse)(?: ([^\n]*))?\n/.exec(this.left) ?? [];
    if (verdict) {
      this.left = this.left.slice(this.left.indexOf("\n") + 1);
      return [verdict, text ?? ""];
    }
    if (this.left.includes("\n")) return ["crashed", await this.end(`answered ${this.left.slice(0, 80)}`)];
    if (isLate) return ["timed out", await this.end(`no answer within ${this.seconds} s`)];
    return ["crashed", await this.end(this.ended ? "ended instead of answering" : "16 MiB without a line end")];
  }

  async end(why = "") {
    if (!this.process) return why;
    this.process.kill("SIGKILL");
    while (!this.ended) await this.change();
    this.process = undefined;
    return `${why} (${this.ended}): ${readFileSync(this.errors, "utf8").slice(-300).trim()}`;
  }
}

/** A map of [outcome, message], or undefined where all is right, of the cases that were tried. */
export async function run(corpus, command, chosen, jobs, seconds, first) {
  const results = new Map(), left = chosen.values(), outcomes = [];
  const blame = (id, ...fault) => {
    outcomes.push(fault[0]);
    results.set(id, results.get(id) ?? fault);
  };
  const work = async (path) => {
    const reader = new Reader(command, seconds, `${path}.errors`);
    let last;
    const late = async () => {
      await new Promise(setImmediate);
      if (reader.process && (reader.left || reader.ended)) {
        blame(last, "crashed", await reader.end("wrote or ended after its answer"));
      }
    };
    for (const { id, file, trials } of left) { // which the workers share
      // A reader that waits for ever is asked some times more, not thousands of times.
      if (first && outcomes.length || outcomes.filter((each) => each === "timed out").length > 20) break;
      const bytes = readFileSync(join(corpus, file));
      results.set(id, undefined);
      for (const trial of trials) {
        await late();
        writeFileSync(path, trial.damage ? damaged(bytes, trial.damage) : bytes);
        let [outcome, text] = await reader.ask(trial.request, path);
        last = id;
        if (outcome === "accept" || outcome === "refuse") [outcome, text] = ["failed", faultOf(trial, outcome, text)];
        if (!text) continue;
        blame(id, outcome, `${trial.request} ${JSON.stringify(trial.damage) ?? ""}: ${text}`);
        await reader.end(); // What it keeps from this request is not to mislead the next.
        break;
      }
    }
    await late();
    await reader.end();
  };
  const folder = mkdtempSync(join(os.tmpdir(), "t4d-conformance-"));
  process.on("exit", () => rmSync(folder, { recursive: true }));
  await Promise.all(Array.from({ length: jobs }, (_, i) => work(join(folder, `${i}.t4d`))));
  return results;
}

const escaped = (text) => text.replace(/[^ -~]/g, "?").replace(/[&<>"]/g, (each) => `&#${each.charCodeAt()};`);

export function junit(results) {
  const lines = [...results].map(([id, wrong]) => {
    const [kind, name] = escaped(id).split("/"), found = wrong ? `<failure message="${escaped(wrong[1])}"/>` : "";
    return `<testcase classname="${kind}" name="${name}">${found}</testcase>\n`;
  });
  const failed = [...results.values()].filter(Boolean).length;
  return `<?xml version="1.0" encoding="UTF-8"?>
<testsuite name="t4d-conformance" tests="${results.size}" failures="${failed}">\n${lines.join("")}</testsuite>\n`;
}

export function badge(results, version) {
  const passed = [...results.values()].filter((wrong) => !wrong).length, isRight = passed === results.size;
  const left = `.t4d corpus ${version}`, right = `${passed} of ${results.size}`;
  return `<svg xmlns="http://www.w3.org/2000/svg" width="240" height="20" role="img" aria-label="${left}: ${right}">
<rect width="130" height="20" fill="#444"/>
<rect x="130" width="110" height="20" fill="${isRight ? "#2e7d32" : "#c62828"}"/>
<g fill="#fff" text-anchor="middle" font-family="sans-serif" font-size="11">
<text x="65" y="14">${left}</text><text x="185" y="14">${right}</text></g></svg>\n`;
}

const USAGE = `Usage: t4d-conformance --reader COMMAND [OPTION...]
Runs a reader of .t4d files, which is started with --serve, against the corpus. Options:
  --only GLOB (repeatable), --without NAMES (zstd,means,pose,grid,hyperplanes), --junit FILE, --badge FILE (SVG),
  --json, --first (stop at the first fault), --corpus FOLDER, --timeout SECONDS (per request), --parallel N`;

/** What matches a glob: a case, its kind or its name. */
const matcher = (glob) => new RegExp(`^(?:[^/]*/)?${glob.replace(/[.+^${}()|\\]/g, "\\$&")
  .replace(/\*/g, ".*").replace(/\?/g, ".")}(?:/.*)?$`);

export async function main(args) {
  const text = { type: "string" }, flag = { type: "boolean" };
  const types = { reader: text, only: { ...text, multiple: true }, without: text, junit: text, badge: text, json: flag,
    first: flag, corpus: text, timeout: text, parallel: text, help: flag };
  let options = { corpus: join(fileURLToPath(import.meta.url), "../corpus"), timeout: 60, parallel: os.cpus().length };
  try {
    options = { ...options, ...parseArgs({ args, options: types }).values };
  } catch (error) {
    console.error(error.message);
  }
  if (options.help || !options.reader) {
    (options.help ? console.log : console.error)(USAGE);
    return options.help ? 0 : 2;
  }
  const { corpus, first } = options, globs = (options.only ?? ["*"]).map(matcher);
  const version = readFileSync(join(corpus, "VERSION"), "utf8").split(/\s/)[1];
  const chosen = cases(corpus, options.without?.split(",")).filter(({ id }) => globs.some((glob) => glob.test(id)));
  if (!chosen.length) {
    console.error("no case has such a name");
    return 2;
  }
  const [jobs, seconds] = [options.parallel, options.timeout].map(Number);
  const results = await run(corpus, options.reader, chosen, jobs, seconds, first);
  if (options.junit) writeFileSync(options.junit, junit(results));
  if (options.badge) writeFileSync(options.badge, badge(results, version));
  const wrong = [...results].filter(([, found]) => found);
  if (options.json) {
    const outcomes = [...results].map(([id, found]) => ({ id, outcome: found?.[0] ?? "passed" }));
    console.log(JSON.stringify({ corpus_version: version, cases: outcomes }));
  } else {
    for (const [id, [outcome, message]] of wrong.slice(0, 20)) console.log(`${outcome} ${id}\n  ${message}`);
    console.log(`${results.size - wrong.length} passed, ${wrong.length} failed (corpus ${version})`);
  }
  return wrong.length ? 1 : 0;
}

// npm starts it by a link.
if (process.argv[1] && fileURLToPath(import.meta.url) === realpathSync(process.argv[1])) {
  process.exitCode = await main(process.argv.slice(2));
}
