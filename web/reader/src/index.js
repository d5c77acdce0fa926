// Reads .t4d files, 4D meshes, as formats/t4d/SPEC.md has them: by ranges, checked, a slab at a time.
export { answering, open, readAll, T4dFile } from './file.js';
export { crc32c } from './crc32c.js';
export { Invalid } from './invalid.js';
export { PartedFile } from './parted.js';
export { cut, cutTable, determinant4, eachRunThatMayBeCut, heightsOf, hyperplane, measure } from './slice.js';
export { blobSource, bytesSource, FetchError, httpSource } from './source.js';
