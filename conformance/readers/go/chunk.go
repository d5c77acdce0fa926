package main

import "regexp"

// A chunk is the header of one.
type chunk struct {
	offset   uint64
	bytes    [28]byte // the header without its checksum
	kind     string
	critical bool
	length   uint64
	front    uint64
	blocks   uint64
	frontSum uint32
}

const chunkHeaderSize = 32

var (
	chunkType  = regexp.MustCompile(`^([A-Z][A-Z0-9]{3}|[a-z][A-Za-z0-9]{3})$`)
	knownTypes = map[string]bool{
		"HEAD": true, "CONN": true, "LAYR": true, "POSE": true, "SLAB": true, "DONE": true, "INDX": true,
	}
)

// end is the offset of what follows the chunk.
func (c chunk) end() uint64 { return c.offset + chunkHeaderSize + padded(c.length) }

// chunkAt reads the header of a chunk.
func (f *file) chunkAt(offset uint64) chunk {
	require(offset%8 == 0 && offset >= headerSize && f.size >= chunkHeaderSize &&
		offset <= f.size-chunkHeaderSize, offset, "C3", "there cannot be a chunk")
	h := f.read(offset, chunkHeaderSize)
	require(checksum(h[:28]) == le.Uint32(h[28:]), offset+28,
		"C4", "the checksum of the chunk header is wrong")
	return f.parseChunk(offset, h[:28])
}

// parseChunk parses a header without its checksum.
func (f *file) parseChunk(offset uint64, h []byte) chunk {
	c := chunk{
		offset: offset, kind: string(h[:4]), critical: h[4]&1 == 1, length: le.Uint64(h[8:]),
		front: uint64(le.Uint32(h[16:])), blocks: uint64(le.Uint32(h[20:])), frontSum: le.Uint32(h[24:]),
	}
	copy(c.bytes[:], h)
	require(chunkType.MatchString(c.kind), offset, "C1", "this is no type of a chunk")
	require(le.Uint32(h[4:]) < 2, offset+4, "C2", "a reserved flag is set")
	require(offset <= f.size-chunkHeaderSize && c.length <= f.size-offset-chunkHeaderSize &&
		c.end() <= f.size, offset+8, "C3", "the chunk does not end inside the file")
	if knownTypes[c.kind] {
		require(c.critical, offset+4, "C7", c.kind+" is not critical")
	} else {
		require(!c.critical, offset,
			"C8", "the file needs chunks of the type "+c.kind+", which this reader does not know")
	}
	if c.blocks == 0 {
		require(c.front == c.length, offset+16, "C9", "front is not the length")
	} else {
		require(c.front%8 == 0 && c.front <= c.length && c.blocks*8 <= c.front, offset+16, "C9",
			"front does not fit the payload or the table")
		require(c.kind != "HEAD" && c.kind != "DONE", offset+20, "C11", c.kind+" has blocks")
	}
	return c
}
