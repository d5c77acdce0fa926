package main

// A conn is a CONN: the cells of a slab, and what its means are means of.
type conn struct {
	vertices, lower, upper, means uint64
	indices                       []uint32 // four of each cell
	cellCount                     uint64
	cellBlocks                    int
	meanSizes, meanSources        []uint32
	attributes                    []attribute
}

// The stored interior vertices are those from lower to firstMean, the upper layer begins at firstUpper.
func (c *conn) firstUpper() uint64 { return c.vertices - c.upper }
func (c *conn) firstMean() uint64  { return c.vertices - c.upper - c.means }

func (f *file) readConn(at chunk) *conn {
	p := f.open(at, "N11")
	count := func() uint64 { return uint64(p.u32()) }
	c := &conn{vertices: count(), lower: count(), upper: count(), means: count()}
	attributes := p.u32()
	require(c.lower+c.upper+c.means <= c.vertices, at.offset, "N1", "there are too few vertices")
	require(c.means == 0 || f.head.has("means"), at.offset,
		"N12", "the file does not name the feature means")
	rangeCount := p.u32()
	ranges := p.take(uint64(rangeCount) * 24)

	cells := p.record()
	require(cells.is(4, typeU32), cells.offset, "N3", "the array of cells has the wrong type")
	c.cellCount, c.cellBlocks = cells.rows, len(cells.blocks)
	require(uint64(rangeCount) == blocksWithBoxes(c.cellBlocks), at.offset,
		"N2", "there is not a range for each block of cells")
	p.load(cells)
	c.indices = cells.u32s()
	for i := uint64(0); i < c.cellCount; i++ {
		cell := c.cell(i)
		for j, v := range cell {
			require(uint64(v) < c.vertices, cells.offset,
				"N4", "a cell has a vertex that is not there")
			for _, w := range cell[:j] {
				require(v != w, cells.offset, "N5", "a cell has a vertex twice")
			}
		}
	}
	if c.means > 0 {
		c.readMeans(p)
	}
	c.attributes = p.attributes(attributes, map[uint8]uint64{ofCells: c.cellCount}, "N10")
	p.end()
	if rangeCount > 0 {
		c.checkRanges(ranges, at.offset)
	}
	return c
}

func (c *conn) cell(i uint64) []uint32 { return c.indices[4*i : 4*i+4] }

// cellsOf are the first cell of a block, and the first after it.
func (c *conn) cellsOf(block int) (first, last uint64) {
	first, last = uint64(block)*blockRows, uint64(block+1)*blockRows
	if last > c.cellCount {
		last = c.cellCount
	}
	return first, last
}

// blocksWithBoxes is the number of ranges and of bounds for a number of blocks of cells.
func blocksWithBoxes(blocks int) uint64 {
	if blocks == 1 {
		return 0
	}
	return uint64(blocks)
}

func (c *conn) readMeans(p *payload) {
	sizes, sources := p.record(), p.record()
	require(sizes.is(1, typeU32) && sources.is(1, typeU32) && sizes.rows == c.means, sizes.offset, "N6",
		"the arrays of means have the wrong types or rows")
	p.load(sizes)
	p.load(sources)
	c.meanSizes, c.meanSources = sizes.u32s(), sources.u32s()
	total := uint64(0)
	for _, size := range c.meanSizes {
		require(size > 0, sizes.offset, "N7", "a mean has no source")
		total += uint64(size)
	}
	require(total == sources.rows, sources.offset,
		"N8", "the mean sizes do not add up to the number of sources")
	for _, s := range c.meanSources {
		v := uint64(s)
		require(v < c.vertices && (v < c.firstMean() || v >= c.firstUpper()), sources.offset,
			"N9", "the source of a mean is none")
	}
}

// eachMean calls do with the sources of each mean.
func (c *conn) eachMean(do func(sources []uint32)) {
	rest := c.meanSources
	for _, size := range c.meanSizes {
		do(rest[:size])
		rest = rest[size:]
	}
}

// A vertexRange is the first vertex, and one more than the last, in the lower layer, the interior and the
// upper layer.
type vertexRange [3][2]uint32

func (r *vertexRange) include(other vertexRange) {
	for part, o := range other {
		switch mine := &r[part]; {
		case o[1] == 0:
		case mine[1] == 0:
			*mine = o
		default:
			if o[0] < mine[0] {
				mine[0] = o[0]
			}
			if o[1] > mine[1] {
				mine[1] = o[1]
			}
		}
	}
}

func (c *conn) rangeOf(vertex uint32) (r vertexRange) {
	part := 1
	if v := uint64(vertex); v < c.lower {
		part = 0
	} else if v >= c.firstUpper() {
		part = 2
	}
	r[part] = [2]uint32{vertex, vertex + 1}
	return r
}

func (c *conn) checkRanges(stored []byte, offset uint64) {
	ofMeans := make([]vertexRange, 0, c.means)
	c.eachMean(func(sources []uint32) {
		var r vertexRange
		for _, s := range sources {
			r.include(c.rangeOf(s))
		}
		ofMeans = append(ofMeans, r)
	})
	for block := 0; block < c.cellBlocks; block++ {
		var r vertexRange
		first, last := c.cellsOf(block)
		for _, vertex := range c.indices[4*first : 4*last] {
			if v := uint64(vertex); v >= c.firstMean() && v < c.firstUpper() {
				r.include(ofMeans[v-c.firstMean()])
			} else {
				r.include(c.rangeOf(vertex))
			}
		}
		for _, part := range r {
			require(part == [2]uint32{le.Uint32(stored), le.Uint32(stored[4:])}, offset,
				"N2", "a range is not that of its cells")
			stored = stored[8:]
		}
	}
}
