// Unpacks Chromium and its renderer without a GPU into the folder `program` beside this file.
import { execFileSync } from 'node:child_process';
import { mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { brotliDecompressSync } from 'node:zlib';

const packed = fileURLToPath(new URL('node_modules/@sparticuz/chromium/bin', import.meta.url));
const program = fileURLToPath(new URL('program', import.meta.url));
const unpacked = (name) => brotliDecompressSync(readFileSync(`${packed}/${name}.br`));

rmSync(program, { recursive: true, force: true });
mkdirSync(program);
execFileSync('tar', ['-x', '-C', program], { input: unpacked('swiftshader.tar') });
writeFileSync(`${program}/chromium`, unpacked('chromium'), { mode: 0o755 });
