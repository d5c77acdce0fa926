package main

import (
	"bytes"
	"encoding/binary"
	"hash/crc32"
	"io"
	"math"
	"os"
)

var le = binary.LittleEndian

// A file is open for reading, and its file header has been checked.
type file struct {
	io.ReaderAt
	size    uint64
	header  [20]byte // without its checksum
	indexed bool
	head    head // once it has been read
}

const (
	headerSize = 24
	footerSize = 40
)

func checksum(data []byte) uint32 { return checksumAfter(0, data) }

// checksumAfter is the checksum of data after bytes that have the checksum before.
func checksumAfter(before uint32, data []byte) uint32 {
	return crc32.Update(before, crc32.MakeTable(crc32.Castagnoli), data)
}

func padded(size uint64) uint64 { return (size + 7) &^ 7 }

func allZero(data []byte) bool { return len(bytes.Trim(data, "\x00")) == 0 }

func float(data []byte) float64 { return math.Float64frombits(le.Uint64(data)) }

func newFile(f *os.File) *file {
	status, err := f.Stat()
	if err != nil {
		panic(refusal{err})
	}
	r := &file{ReaderAt: f, size: uint64(status.Size())}
	require(r.size >= headerSize, 0, "H1", "too short for a file header")
	h := r.read(0, headerSize)
	require(string(h[:8]) == "\x89T4D\r\n\x1a\n", 0, "H1", "this is not a .t4d file")
	require(checksum(h[:20]) == le.Uint32(h[20:]), 20,
		"H2", "the checksum of the file header is wrong")
	if major := le.Uint16(h[8:]); major != 1 {
		refuse("byte 8: H3: the file has version %d.%d, this reader reads 1.0", major, le.Uint16(h[10:]))
	}
	require(le.Uint32(h[12:]) < 2, 12, "H4", "a reserved flag is set")
	require(allZero(h[16:20]), 16, "H5", "reserved bytes are not 0")
	r.indexed = h[12] == 1
	copy(r.header[:], h)
	return r
}

// read returns bytes that are known to lie inside the file.
func (f *file) read(offset, size uint64) []byte {
	data := make([]byte, size)
	if _, err := f.ReadAt(data, int64(offset)); err != nil {
		panic(refusal{err})
	}
	return data
}
