package main

import "math"

const blockRows = 65536

// An array has rows of a fixed number of scalars of one type.
type array struct {
	kind, components, codec uint8
	rows                    uint64
	data                    []byte // row after row, uncompressed
	offset                  uint64 // of the record
	blocks                  []block
}

var scalarSizes = [...]uint64{1: 1, 1, 2, 2, 4, 4, 8, 8, 4, 8}

const (
	typeU8  = 1
	typeU32 = 5
	typeI32 = 6
	typeU64 = 7
	typeF32 = 9
	typeF64 = 10
)

func newArray(kind, components uint8, rows uint64) *array {
	a := &array{kind: kind, components: components, rows: rows}
	a.data = make([]byte, rows*a.rowSize())
	return a
}

func (a *array) rowSize() uint64 { return uint64(a.components) * scalarSizes[a.kind] }

func (a *array) row(i uint64) []byte {
	return a.data[i*a.rowSize() : (i+1)*a.rowSize()]
}

// rowsIn is the number of rows in a block.
func (a *array) rowsIn(block int) uint64 {
	if rest := a.rows - uint64(block)*blockRows; rest < blockRows {
		return rest
	}
	return blockRows
}

// record reads the record of an array, whose contents load reads.
func (p *payload) record() *array {
	offset := p.position()
	r := p.take(16)
	a := &array{kind: r[0], components: r[1], codec: r[2], rows: le.Uint64(r[8:]), offset: offset}
	require(a.kind >= 1 && a.kind <= 10, offset, "A1", "there is no such scalar type")
	require(a.components > 0, offset+1, "A2", "the array has no components")
	require(a.codec <= 2, offset+2, "A3", "there is no such codec")
	require(allZero(r[3:8]), offset+3, "A4", "reserved bytes are not 0")
	blocks := a.rows / blockRows
	if a.rows%blockRows > 0 {
		blocks++
	}
	require(blocks <= uint64(len(p.blocks)-p.used), offset+8,
		"A5", "the array has more rows than the blocks that are left")
	a.blocks = p.blocks[p.used : p.used+int(blocks)]
	p.used += int(blocks)
	require(a.rows > 0 || a.codec == 0, offset+2, "A6", "the codec of no rows is not 0")
	for i, b := range a.blocks {
		size := a.rowsIn(i) * a.rowSize()
		require(a.codec > 0 || b.size == size, b.offset,
			"A7", "the block has not the size of its rows")
		require(size <= 1024*b.size, b.offset,
			"A9", "the block would be expanded more than 1,024 times")
	}
	require(a.codec < 2 || a.kind == typeU32, offset, "A8", "codec 2 is for scalar type 5")
	require(a.codec == 0 || p.head.has("zstd"), offset+2,
		"A13", "the file does not name the feature zstd")
	return a
}

// is tells whether the array has so many components, of one of these types.
func (a *array) is(components uint8, kinds ...uint8) bool {
	for _, kind := range kinds {
		if a.kind == kind {
			return a.components == components
		}
	}
	return false
}

// load reads the blocks of an array.
func (p *payload) load(a *array) {
	a.data = make([]byte, a.rows*a.rowSize())
	parallel(len(a.blocks), func(i int) {
		rows := a.rowsIn(i)
		to := a.data[uint64(i)*blockRows*a.rowSize():][:rows*a.rowSize()]
		b := a.blocks[i]
		data := p.block(b)
		switch a.codec {
		case 0:
			copy(to, data)
		case 1:
			transpose(to, decompress(data, b.offset, uint64(len(to)), uint64(len(to))), rows)
		case 2:
			scalars := rows * uint64(a.components)
			repeats(to, decompress(data, b.offset, scalars, 5*scalars), rows, b.offset)
		}
	})
}

// transpose undoes codec 1.
func transpose(to, content []byte, rows uint64) {
	size := uint64(len(to)) / rows
	for j := uint64(0); j < size; j++ {
		for i, column := uint64(0), content[j*rows:]; i < rows; i++ {
			to[i*size+j] = column[i]
		}
	}
}

// repeats undoes codec 2.
func repeats(to, content []byte, rows, offset uint64) {
	scalars := uint64(len(to)) / 4
	components := scalars / rows
	distances := content[:scalars]
	stored := uint64(0)
	for _, d := range distances {
		if d == 0 {
			stored++
		}
	}
	require(uint64(len(content)) == scalars+4*stored, offset,
		"A15", "the block has not 4 bytes for each distance of 0")
	numbers := make([]byte, 4*stored)
	if stored > 0 {
		transpose(numbers, content[scalars:], stored)
	}
	previous := uint32(0)
	for k := uint64(0); k < scalars; k++ {
		d := uint64(distances[k%components*rows+k/components])
		require(d <= k, offset, "A14", "a distance points before the block")
		if d > 0 {
			copy(to[4*k:4*k+4], to[4*(k-d):])
		} else {
			z := le.Uint32(numbers)
			numbers = numbers[4:]
			previous += z>>1 ^ -(z & 1)
			le.PutUint32(to[4*k:], previous)
		}
	}
}

// u32s are the scalars of an array of type 5.
func (a *array) u32s() []uint32 {
	numbers := make([]uint32, len(a.data)/4)
	for i := range numbers {
		numbers[i] = le.Uint32(a.data[4*i:])
	}
	return numbers
}

// f64 is a scalar of an array of type 9 or 10.
func (a *array) f64(i uint64) float64 {
	if a.kind == typeF32 {
		return float64(math.Float32frombits(le.Uint32(a.data[4*i:])))
	}
	return float(a.data[8*i:])
}
