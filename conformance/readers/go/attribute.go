package main

import "math"

// An attribute is named numbers for each vertex or each cell.
type attribute struct {
	domain uint8
	name   string
	*array
}

const (
	ofVertices = 1
	ofCells    = 2
)

var domainNames = [...]string{ofVertices: "vertex", ofCells: "cell"}

// attributes reads attributes of the domains for which there is a number of rows.
func (p *payload) attributes(n uint32, rows map[uint8]uint64, domainRule string) (found []attribute) {
	for ; n > 0; n-- {
		offset := p.position()
		domain := p.take(1)[0]
		require(domain == ofVertices || domain == ofCells, offset, "T1", "there is no such domain")
		expected, ok := rows[domain]
		require(ok, offset, domainRule, "an attribute has the wrong domain")
		p.zeros(3, "T2")
		size := uint64(p.u32())
		require(size >= 1 && size <= 255 && size <= uint64(len(p.front)-p.at), offset+4,
			"T3", "the name does not fit")
		name := string(p.take(size))
		require(isName(name), offset+8, "T4", "the name of the attribute is none")
		p.zeros(padded(size)-size, "T5")
		a := p.record()
		require(a.rows == expected, a.offset+8,
			"T6", "the attribute has not a row for each vertex or cell")
		p.load(a)
		found = append(found, attribute{domain, name, a})
	}
	requireDifferent(found, p.offset)
	return found
}

func requireDifferent(attributes []attribute, offset uint64) {
	type key struct {
		domain uint8
		name   string
	}
	seen := map[key]bool{}
	for _, a := range attributes {
		k := key{a.domain, a.name}
		require(!seen[k], offset, "T7", "two attributes have the same name "+a.name)
		seen[k] = true
	}
}

func (a attribute) alike(b attribute) bool {
	return a.domain == b.domain && a.name == b.name && a.kind == b.kind && a.components == b.components
}

// mean returns the row of a mean of some rows.
func (a *array) mean(sources []uint32) (row []byte) {
	if a.kind != typeF32 && a.kind != typeF64 {
		return a.row(uint64(sources[0]))
	}
	for c := uint64(0); c < uint64(a.components); c++ {
		scalar := func(row uint32) float64 { return a.f64(uint64(row)*uint64(a.components) + c) }
		sum := scalar(sources[0])
		for _, s := range sources[1:] {
			sum += scalar(s)
		}
		mean := sum / float64(len(sources))
		switch {
		case a.kind == typeF32 && math.IsNaN(mean):
			row = le.AppendUint32(row, 0x7fc00000)
		case a.kind == typeF32:
			row = le.AppendUint32(row, math.Float32bits(float32(mean)))
		case math.IsNaN(mean):
			row = le.AppendUint64(row, 0x7ff8000000000000)
		default:
			row = le.AppendUint64(row, math.Float64bits(mean))
		}
	}
	return row
}
