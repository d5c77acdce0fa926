package main

import (
	"fmt"
	"math"
)

type description struct {
	Version  string            `json:"version"`
	Features []string          `json:"features"`
	Bodies   []bodyDescription `json:"bodies"`
}

type bodyDescription struct {
	Name             string            `json:"name"`
	Vertices         uint64            `json:"vertices,string"`
	Cells            uint64            `json:"cells,string"`
	Begin            double            `json:"begin"`
	End              double            `json:"end"`
	Min              []double          `json:"min"`
	Max              []double          `json:"max"`
	Hypervolume      double            `json:"hypervolume"`
	VerticesChecksum checksumText      `json:"vertices_checksum"`
	CellsChecksum    checksumText      `json:"cells_checksum"`
	Slabs            []slabDescription `json:"slabs"`
}

type slabDescription struct {
	Begin      double                 `json:"begin"`
	End        double                 `json:"end"`
	Vertices   uint64                 `json:"vertices,string"`
	Lower      uint64                 `json:"lower,string"`
	Upper      uint64                 `json:"upper,string"`
	Means      uint64                 `json:"means,string"`
	Cells      uint64                 `json:"cells,string"`
	Min        []double               `json:"min"`
	Max        []double               `json:"max"`
	Attributes []attributeDescription `json:"attributes"`
}

type attributeDescription struct {
	Domain     string       `json:"domain"`
	Name       string       `json:"name"`
	Type       uint8        `json:"type,string"`
	Components uint8        `json:"components,string"`
	Checksum   checksumText `json:"checksum"`
}

// describe reads everything.
func describe(f *file) description {
	found := map[uint32]bodyDescription{}
	c := scan(f, func(s *slab) {
		b := found[s.body]
		b.Hypervolume += double(s.hypervolume())
		b.VerticesChecksum = checksumText(s.verticesAfter(uint32(b.VerticesChecksum)))
		b.CellsChecksum = checksumText(s.cellsAfter(uint32(b.CellsChecksum)))
		b.Slabs = append(b.Slabs, s.describe())
		found[s.body] = b
	})
	version := fmt.Sprintf("%d.%d", le.Uint16(f.header[8:]), le.Uint16(f.header[10:]))
	d := description{Version: version, Features: c.head.features}
	for i, said := range c.bodies {
		b := found[uint32(i)]
		b.Name, b.Vertices, b.Cells = c.head.bodies[i], said.vertices, said.cells
		b.Begin, b.End = double(said.begin), double(said.end)
		b.Min, b.Max = said.bounds.limits(3)
		d.Bodies = append(d.Bodies, b)
	}
	return d
}

func (s *slab) describe() slabDescription {
	d := slabDescription{
		Begin: double(s.begin), End: double(s.end),
		Vertices: s.vertices, Lower: s.conn.lower, Upper: s.conn.upper, Means: s.means, Cells: s.cellCount,
		Attributes: []attributeDescription{},
	}
	d.Min, d.Max = s.box.limits(4)
	for _, a := range s.attributes {
		d.Attributes = append(d.Attributes, attributeDescription{
			domainNames[a.domain], a.name, a.kind, a.components, checksumText(checksum(a.data)),
		})
	}
	return d
}

func (s *slab) hypervolume() (sum float64) {
	for i := uint64(0); i < s.cellCount; i++ {
		v := s.cell(i)
		sum += det4(s.points[v[0]], s.points[v[1]], s.points[v[2]], s.points[v[3]]) / 24
	}
	return sum
}

// verticesAfter is the checksum of the vertices after bytes that have the checksum before.
func (s *slab) verticesAfter(before uint32) uint32 {
	var row [32]byte
	for _, p := range s.points {
		for i, x := range p {
			le.PutUint64(row[8*i:], math.Float64bits(x))
		}
		before = checksumAfter(before, row[:])
	}
	return before
}

func (s *slab) cellsAfter(before uint32) uint32 {
	data := make([]byte, 4*len(s.indices))
	for i, v := range s.indices {
		le.PutUint32(data[4*i:], v)
	}
	return checksumAfter(before, data)
}
