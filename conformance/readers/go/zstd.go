package main

// #cgo LDFLAGS: -lzstd
// #include <zstd.h>
import "C"

import "unsafe"

// decompress returns the content of a block that is one Zstandard frame; the content has at least and at
// most so many bytes.
func decompress(frame []byte, offset, least, most uint64) []byte {
	from, size := unsafe.Pointer(&frame[0]), C.size_t(len(frame))
	// Some builds of the library read frames of its first versions, too.
	require(len(frame) >= 4 && le.Uint32(frame) == C.ZSTD_MAGICNUMBER &&
		C.ZSTD_findFrameCompressedSize(from, size) == size &&
		C.ZSTD_getDictID_fromFrame(from, size) == 0, offset, "A10",
		"the block is not one Zstandard frame without dictionary")
	// Where the size is missing, the library returns a number near 2^64.
	declared := uint64(C.ZSTD_getFrameContentSize(from, size))
	require(least <= declared && declared <= most, offset,
		"A11", "the frame does not declare the right size")
	content := make([]byte, declared)
	n := C.ZSTD_decompress(unsafe.Pointer(&content[0]), C.size_t(declared), from, size)
	require(uint64(n) == declared, offset, "A12", "the frame does not decompress")
	return content
}
