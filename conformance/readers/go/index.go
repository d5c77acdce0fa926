package main

// readIndex makes the catalog of a file from its footer, INDX and DONE.
func readIndex(f *file) *catalog {
	c := newCatalog(f)
	require(f.size >= headerSize+footerSize, 0, "F1", "the file is too short for a footer")
	at := f.size - footerSize
	footer := f.read(at, footerSize)
	require(string(footer[32:]) == "\n\x1a\n\rD4T\x89", at+32,
		"F1", "the end signature is wrong: the file may be truncated")
	require(checksum(footer[:28]) == le.Uint32(footer[28:]), at+28,
		"F2", "the checksum of the footer is wrong")
	require(le.Uint64(footer[16:]) == f.size, at+16, "F3", "the file has another length")

	indx := f.chunkAt(le.Uint64(footer))
	require(indx.kind == "INDX", at, "F4", "there is no INDX")
	require(indx.end() == at, at, "O4", "INDX is not followed by the footer")
	require(le.Uint32(f.read(indx.offset+28, 4)) == le.Uint32(footer[24:]), at+24,
		"F6", "INDX has another header checksum")

	p := f.open(indx, "I8")
	require(string(p.take(20)) == string(f.header[:]), indx.offset,
		"I1", "the file header is another one")
	slabs := uint64(p.u32())
	array := func(rows uint64, components, kind uint8) *array {
		a := p.record()
		require(a.is(components, kind), a.offset, "I7", "an array has the wrong type")
		require(rows == anyRows || a.rows == rows, a.offset,
			"I3", "there is not a row for each slab")
		p.load(a)
		return a
	}
	head := p.record()
	require(head.is(1, typeU8) && head.codec == 0, head.offset, "I7", "head has the wrong type")
	p.load(head)
	f.head = parseHead(head.data, indx.offset)
	chunks := array(anyRows, 28, typeU8)
	times, parts := array(slabs, 2, typeF64), array(slabs, 3, typeU64)
	bodies, cells, bounds := array(slabs, 1, typeU32), array(slabs, 1, typeU64), array(slabs, 6, typeF64)
	p.end()

	c.readChunks(chunks, indx.offset)
	first, done := c.chunks[0], c.chunks[len(c.chunks)-1]
	require(first.length == uint64(len(head.data)) && first.frontSum == checksum(head.data), indx.offset,
		"I1", "head is not that of the file")
	require(done.offset == le.Uint64(footer[8:]), at+8, "F5", "there is no DONE")
	c.chunks = c.chunks[:len(c.chunks)-1]
	c.readDone(done)
	c.chunks = append(c.chunks, done)

	total := uint64(0)
	for _, at := range c.chunks {
		if at.kind != "SLAB" {
			continue
		}
		i := uint64(len(c.slabs))
		require(i < slabs, indx.offset, "I3", "there are more slabs")
		c.slabs = append(c.slabs, entry{
			offset: at.offset, begin: times.f64(2 * i), end: times.f64(2*i + 1),
			at:   parseParts(parts.row(i)),
			body: le.Uint32(bodies.row(i)), cells: le.Uint64(cells.row(i)), bounds: spaceBox(bounds.row(i)),
		})
		total += c.slabs[i].cells
	}
	require(uint64(len(c.slabs)) == slabs, indx.offset, "I3", "there are fewer slabs")
	c.check(done.offset)
	c.requireModest(total)
	return c
}

const anyRows = ^uint64(0)

// readChunks reads the list of the chunks before INDX, at an offset.
func (c *catalog) readChunks(list *array, indx uint64) {
	next := uint64(headerSize)
	for i := uint64(0); i < list.rows; i++ {
		require(next < indx, indx, "I2", "the chunks do not end where INDX begins")
		at := c.parseChunk(next, list.row(i))
		require((at.kind == "HEAD") == (i == 0) && (at.kind == "DONE") == (i == list.rows-1) &&
			at.kind != "INDX", indx, "I2",
			"the chunks do not begin with HEAD and end with DONE")
		c.add(at)
		next = at.end()
	}
	require(list.rows > 0 && next == indx, indx, "I2", "the chunks do not end where INDX begins")
}
