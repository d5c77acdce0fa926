package main

// scan reads a whole file, and hands each slab to use.
func scan(f *file, use func(*slab)) *catalog {
	c := newCatalog(f)
	vertices := map[uint32]uint64{}
	cells := uint64(0)
	at := f.chunkAt(headerSize)
	for ; at.kind != "DONE"; at = f.chunkAt(at.end()) {
		first := len(c.chunks) == 0
		require(!first || at.kind == "HEAD", at.offset, "O1", "the first chunk is not HEAD")
		require(first || at.kind != "HEAD", at.offset, "O2", "there is another HEAD")
		require(at.kind != "INDX", at.offset, "O3", "there is no DONE before INDX")
		switch at.kind {
		case "HEAD":
			p := f.open(at, "M3")
			f.head = parseHead(p.take(at.length), p.position())
		case "SLAB":
			s := c.readSlab(at)
			c.slabs = append(c.slabs, s.entry)
			if _, begun := vertices[s.body]; begun {
				vertices[s.body] -= s.conn.lower
			}
			vertices[s.body] += s.vertices
			cells += s.entry.cells
			c.requireModest(cells)
			use(s)
		case "CONN", "LAYR", "POSE": // read by the slabs that name them
		default:
			p := f.open(at, "C9")
			for _, b := range p.blocks {
				p.block(b)
			}
		}
		c.add(at)
	}
	require(len(c.chunks) > 0, at.offset, "O1", "the first chunk is not HEAD")
	c.readDone(at)
	c.add(at)
	for _, part := range c.chunks {
		isPart := part.kind == "CONN" || part.kind == "LAYR" || part.kind == "POSE"
		require(!isPart || c.named[part.offset], part.offset, "O6", "no slab needs this part")
	}
	c.check(at.offset)
	for body, said := range c.bodies {
		require(vertices[uint32(body)] == said.vertices, at.offset,
			"D6", "a body has not so many vertices")
	}
	if f.indexed {
		c.checkIndex(at.end())
	} else {
		require(at.end() == f.size, at.end(), "O5", "the file does not end with DONE")
	}
	return c
}

// checkIndex demands that INDX, at an offset, is right.
func (c *catalog) checkIndex(offset uint64) {
	head := c.head
	indx := c.chunkAt(offset)
	require(indx.kind == "INDX", offset, "O4", "DONE is not followed by INDX")
	require(indx.end()+footerSize == c.size, indx.end(),
		"O4", "INDX is not followed by the footer, or the file does not end with it")
	index := readIndex(c.file)
	require(string(index.head.bytes) == string(head.bytes), offset,
		"I1", "head is not that of the file")
	require(len(index.chunks) == len(c.chunks), offset, "I2", "chunks are not those of the file")
	for i, at := range c.chunks {
		require(index.chunks[i] == at, offset, "I2", "chunks are not those of the file")
	}
	for i, s := range c.slabs {
		c.requireSame(index.slabs[i], s, offset)
	}
}

// requireSame demands that INDX is right about a slab.
func (c *catalog) requireSame(said, found entry, offset uint64) {
	require(said.begin == found.begin && said.end == found.end && said.at == found.at &&
		said.body == found.body,
		offset, "I4", "INDX has other times, parts or body")
	require(said.cells == found.cells, offset, "I5", "INDX has another number of cells")
	require(said.bounds == found.bounds, offset, "I6", "INDX has other bounds")
}
