package main

import "sort"

// A catalog has the chunks before INDX and the slabs of a file.
type catalog struct {
	*file
	chunks []chunk
	at     map[uint64]chunk
	slabs  []entry
	bodies []summary

	offsets     map[string][]uint64 // of the chunks by type
	named       map[uint64]bool     // parts, by a SLAB or a POSE
	parts, last map[uint64]any      // those of this slab, and of the one read before it
}

// A summary is what DONE says of a body.
type summary struct {
	slabs, vertices, cells uint64
	begin, end             float64
	bounds                 box // of x, y, z
}

func newCatalog(f *file) *catalog {
	return &catalog{file: f, at: map[uint64]chunk{}, offsets: map[string][]uint64{}, named: map[uint64]bool{}}
}

func (c *catalog) add(at chunk) {
	c.chunks = append(c.chunks, at)
	c.at[at.offset] = at
	c.offsets[at.kind] = append(c.offsets[at.kind], at.offset)
}

// find returns the chunk at a distance that another one names.
func (c *catalog) find(distance uint64, by chunk, rule string, kinds ...string) chunk {
	at := c.at[by.offset-distance]
	for _, kind := range kinds {
		if at.kind == kind && at.offset < by.offset {
			c.named[at.offset] = true
			return at
		}
	}
	require(false, by.offset, rule, "a part is not before the chunk that names it")
	panic("unreachable")
}

// newParts forgets the parts that the slab read before has not used.
func (c *catalog) newParts() { c.parts, c.last = map[uint64]any{}, c.parts }

// part returns what is read from a chunk, once for slabs that follow one another.
func part[T any](c *catalog, at chunk, read func() T) T {
	value, ok := c.parts[at.offset]
	if !ok {
		value, ok = c.last[at.offset]
	}
	if !ok {
		value = read()
	}
	c.parts[at.offset] = value
	return value.(T)
}

func (c *catalog) connAt(distance uint64, slab chunk) *conn {
	at := c.find(distance, slab, "S2", "CONN")
	return part(c, at, func() *conn { return c.readConn(at) })
}

func (c *catalog) layerAt(distance uint64, slab chunk) *layer {
	at := c.find(distance, slab, "S3", "LAYR", "POSE")
	return part(c, at, func() *layer {
		if at.kind == "POSE" {
			return c.readPose(at)
		}
		return c.readLayer(at)
	})
}

func (c *catalog) posedLayer(distance uint64, pose chunk) *layer {
	at := c.find(distance, pose, "K2", "LAYR")
	c.requireNear(distance, pose, "K6")
	return part(c, at, func() *layer { return c.readLayer(at) })
}

// requireNear demands that a part is one of the last of its type before the chunk that names it. A layer
// that is missing, at the distance 0, is near.
func (c *catalog) requireNear(distance uint64, by chunk, rule string) {
	at := c.at[by.offset-distance]
	offsets, most := c.offsets[at.kind], 16*len(c.head.bodies)
	before := sort.Search(len(offsets), func(i int) bool { return offsets[i] >= by.offset })
	require(before <= most || offsets[before-most] <= at.offset, by.offset, rule, "a part is too far back")
}

// readDone reads the DONE that follows the chunks.
func (c *catalog) readDone(at chunk) {
	p := c.open(at, "D4")
	require(p.u64() == uint64(len(c.chunks)), at.offset, "D1", "there are not so many chunks")
	require(uint64(p.u32()) == uint64(len(c.head.bodies)), at.offset,
		"D2", "there are not so many bodies")
	p.zeros(4, "D3")
	for range c.head.bodies {
		s := summary{slabs: p.u64(), vertices: p.u64(), cells: p.u64(), begin: p.f64(), end: p.f64()}
		s.bounds = p.spaceBox()
		c.bodies = append(c.bodies, s)
	}
	p.end()
}

// spaceBox reads a minimum and a maximum of x, y, z.
func (p *payload) spaceBox() box { return spaceBox(p.take(48)) }

func spaceBox(data []byte) (b box) {
	for i := 0; i < 3; i++ {
		b.min[i], b.max[i] = float(data[8*i:]), float(data[24+8*i:])
	}
	return b
}

// sameLayer tells whether the layers at two offsets are the same, or copies.
func (c *catalog) sameLayer(a, b uint64) bool {
	return a == b || c.at[a].kind == "LAYR" && c.at[a].bytes == c.at[b].bytes
}

// check demands that slabs follow one another, and that DONE is right about them, but for vertices.
func (c *catalog) check(doneOffset uint64) {
	found := make([]summary, len(c.head.bodies))
	previous := make([]entry, len(found))
	for i := range found {
		found[i].bounds = emptyBox().space()
	}
	for _, s := range c.slabs {
		require(finite(s.begin, s.end) && s.begin <= s.end, s.offset, "S1", "begin or end is wrong")
		require(uint64(s.body) < uint64(len(found)), s.offset, "S4", "there is no such body")
		f, before := &found[s.body], previous[s.body]
		lower, shared := s.offsetOf(s.at.lower), before.offsetOf(before.at.upper)
		c.requireNear(s.at.conn, c.at[s.offset], "S12")
		c.requireNear(s.at.upper, c.at[s.offset], "S12")
		if lower != shared {
			c.requireNear(s.at.lower, c.at[s.offset], "S12")
		}
		if f.slabs == 0 {
			f.begin = s.begin
		} else {
			require(c.sameLayer(lower, shared), s.offset,
				"S7", "lower is not upper of the slab before")
			require(s.begin == before.end || s.at.lower == 0 && s.begin > before.end, s.offset, "S8",
				"the slab does not begin where the slab before ends")
		}
		f.slabs++
		f.cells += s.cells
		f.end = s.end
		f.bounds.join(s.bounds)
		previous[s.body] = s
	}
	for i, f := range found {
		said := c.bodies[i]
		require(f.slabs == said.slabs && f.slabs > 0, doneOffset,
			"D5", "a body has not so many slabs")
		require(f.cells == said.cells, doneOffset, "D6", "a body has not so many cells")
		require(f.begin == said.begin && f.end == said.end, doneOffset,
			"D7", "a body begins or ends at another time")
		require(f.bounds == said.bounds, doneOffset, "D8", "a body has another minimum or maximum")
	}
}

// requireModest refuses files that would take too long.
func (c *catalog) requireModest(cells uint64) {
	if cells > 100e6 && cells > 10000*c.size {
		refuse("the file has more than 100 million cells and 10,000 a byte; see requireModest")
	}
}
