package main

// An entry is what INDX says of a SLAB.
type entry struct {
	offset     uint64
	begin, end float64
	at         parts
	body       uint32
	cells      uint64
	bounds     box // of x, y, z
}

// Parts are the distances to the parts of a slab, 0 for an empty layer.
type parts struct{ conn, lower, upper uint64 }

// offsetOf is the offset in the file of a part, 0 for none.
func (e entry) offsetOf(distance uint64) uint64 {
	if distance == 0 {
		return 0
	}
	return e.offset - distance
}

func parseParts(stored []byte) parts {
	return parts{le.Uint64(stored), le.Uint64(stored[8:]), le.Uint64(stored[16:])}
}

// A slab is a part of a mesh, put together.
type slab struct {
	entry
	*conn
	points     []point // lower layer, interior, means, upper layer
	box        box
	attributes []attribute
}

// readSlab reads the SLAB at a chunk of the catalog, and puts it together.
func (c *catalog) readSlab(at chunk) *slab {
	p := c.open(at, "S9")
	s := &slab{box: emptyBox()}
	s.offset, s.begin, s.end = at.offset, p.f64(), p.f64()
	s.at, s.body = parseParts(p.take(24)), p.u32()
	attributes, boundCount := p.u32(), p.u32()
	p.zeros(4, "S11")
	bounds := p.take(uint64(boundCount) * 64)
	c.newParts()
	s.conn = c.connAt(s.at.conn, at)
	s.cells = s.cellCount
	require(boundCount == 0 || uint64(boundCount) == blocksWithBoxes(s.cellBlocks), at.offset,
		"S10", "there are not bounds for each block of cells")

	interior, _ := p.positions("S5")
	times := p.record()
	require(times.is(1, typeF64) && times.rows == uint64(len(interior)), times.offset,
		"S6", "the interior times have the wrong type or rows")
	p.load(times)
	for i := range interior {
		interior[i][3] = times.f64(uint64(i))
	}
	own := p.attributes(attributes, map[uint8]uint64{ofVertices: times.rows, ofCells: s.cells}, "T1")
	p.end()

	lower, upper := &layer{}, &layer{}
	if s.at.lower != 0 {
		lower = c.layerAt(s.at.lower, at)
		require(lower.time == s.begin, at.offset, "P3", "the time of the lower layer is not begin")
	}
	if s.at.upper != 0 {
		upper = c.layerAt(s.at.upper, at)
		require(upper.time == s.end, at.offset, "P3", "the time of the upper layer is not end")
	}
	require(uint64(len(lower.points)) == s.conn.lower && uint64(len(upper.points)) == s.conn.upper &&
		uint64(len(interior)) == s.firstMean()-s.conn.lower, at.offset,
		"P1", "the parts have not the vertices of the CONN")
	s.join(lower.points, interior, upper.points)
	s.joinAttributes(own, lower.attributes, upper.attributes, c.size)
	s.checkPoints(bounds)
	return s
}

// join makes the vertices of those that are stored.
func (s *slab) join(lower, interior, upper []point) {
	s.points = make([]point, s.vertices)
	copy(s.points, lower)
	copy(s.points[s.conn.lower:], interior)
	copy(s.points[s.firstUpper():], upper)
	next := s.firstMean()
	s.eachMean(func(sources []uint32) {
		mean := s.points[sources[0]]
		for _, v := range sources[1:] {
			for i, x := range s.points[v] {
				mean[i] += x
			}
		}
		for i := range mean {
			mean[i] /= float64(len(sources))
		}
		s.points[next] = mean
		next++
	})
}

func (s *slab) checkPoints(bounds []byte) {
	for v, p := range s.points {
		require(finite(p[:]...), s.offset, "P2", "a coordinate is not finite")
		isInterior := uint64(v) >= s.conn.lower && uint64(v) < s.firstUpper()
		require(!isInterior || s.begin <= p[3] && p[3] <= s.end, s.offset,
			"P4", "the time of a vertex is not one of the slab")
		s.box.add(p)
	}
	s.bounds = s.box.space()
	for block := 0; len(bounds) > 0; block++ {
		b := emptyBox()
		first, last := s.cellsOf(block)
		for _, v := range s.indices[4*first : 4*last] {
			b.add(s.points[v])
		}
		for _, number := range append(b.min[:], b.max[:]...) {
			require(number == float(bounds), s.offset, "S10", "bounds are not those of their cells")
			bounds = bounds[8:]
		}
	}
}

// joinAttributes makes the attributes of the slab of its own and those of its layers.
func (s *slab) joinAttributes(own, lower, upper []attribute, size uint64) {
	var interior, cells, joined []attribute
	for _, a := range own {
		if a.domain == ofVertices {
			interior = append(interior, a)
		} else {
			cells = append(cells, a)
		}
	}
	stored := s.firstMean() - s.conn.lower
	require(stored > 0 || len(interior) == 0, s.offset,
		"P5", "a slab that stores no vertex has attributes of vertices")
	begun := false
	for _, part := range []struct {
		first, vertices uint64
		attributes      []attribute
	}{{0, s.conn.lower, lower}, {s.conn.lower, stored, interior}, {s.firstUpper(), s.conn.upper, upper}} {
		if part.vertices == 0 {
			continue
		}
		if !begun {
			for _, a := range part.attributes {
				if s.means*a.rowSize() > 1024*size {
					refuse("the means of a slab inherit more than 1,024 times the bytes of the file")
				}
				values := newArray(a.kind, a.components, s.vertices)
				joined = append(joined, attribute{a.domain, a.name, values})
			}
			begun = true
		}
		require(len(part.attributes) == len(joined), s.offset,
			"P5", "the parts have not the same attributes")
		for i, a := range part.attributes {
			require(a.alike(joined[i]), s.offset, "P5", "the parts have not the same attributes")
			copy(joined[i].data[part.first*a.rowSize():], a.data)
		}
	}
	for _, a := range joined {
		mean := s.firstMean()
		s.eachMean(func(sources []uint32) {
			copy(a.row(mean), a.mean(sources))
			mean++
		})
	}
	s.attributes = append(append(append([]attribute{}, s.conn.attributes...), joined...), cells...)
	requireDifferent(s.attributes, s.offset)
}
