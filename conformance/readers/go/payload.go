package main

// A payload is read field by field.
type payload struct {
	*file
	chunk
	front   []byte
	at      int // of the next field in the front
	blocks  []block
	used    int    // blocks that belong to arrays read so far
	endRule string // that the fields break where they end too early or too late
}

type block struct {
	offset, size uint64
	sum          uint32
}

// open reads the front of a chunk, which begins with this header if the index is right.
func (f *file) open(c chunk, endRule string) *payload {
	begin := c.offset + chunkHeaderSize
	require(f.chunkAt(c.offset).bytes == c.bytes, c.offset,
		"I2", "the chunk does not begin with the header that INDX has")
	p := &payload{file: f, chunk: c, front: f.read(begin, c.front), endRule: endRule}
	require(checksum(p.front) == c.frontSum, begin, "C5", "the front checksum is wrong")
	next := begin + c.front
	for i := uint64(0); i < c.blocks; i++ {
		b := block{next, uint64(le.Uint32(p.front[8*i:])), le.Uint32(p.front[8*i+4:])}
		next += padded(b.size)
		p.blocks = append(p.blocks, b)
	}
	require(next == begin+c.length, begin, "C9", "the blocks do not fill the payload")
	if c.blocks == 0 {
		f.requirePadding(next, c.end()-next)
	}
	p.at = 8 * len(p.blocks)
	return p
}

func (f *file) requirePadding(offset, size uint64) {
	require(allZero(f.read(offset, size)), offset, "C6", "the padding is not zero")
}

// block reads a block.
func (p *payload) block(b block) []byte {
	data := p.read(b.offset, b.size)
	require(checksum(data) == b.sum, b.offset, "C10", "the checksum of the block is wrong")
	p.requirePadding(b.offset+b.size, padded(b.size)-b.size)
	return data
}

// position is the offset of the next field in the file.
func (p *payload) position() uint64 { return p.chunk.offset + chunkHeaderSize + uint64(p.at) }

func (p *payload) take(n uint64) []byte {
	require(n <= uint64(len(p.front)-p.at), p.position(), p.endRule, "the fields end too early")
	p.at += int(n)
	return p.front[p.at-int(n) : p.at]
}

func (p *payload) u32() uint32  { return le.Uint32(p.take(4)) }
func (p *payload) u64() uint64  { return le.Uint64(p.take(8)) }
func (p *payload) f64() float64 { return float(p.take(8)) }

func (p *payload) zeros(n uint64, rule string) {
	require(allZero(p.take(n)), p.position()-n, rule, "reserved bytes or padding are not 0")
}

func (p *payload) end() {
	require(p.at == len(p.front), p.position(), p.endRule, "the fields end too late")
	require(p.used == len(p.blocks), p.position(), p.endRule, "a block is left")
}
