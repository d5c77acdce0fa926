package main

import "fmt"

type description struct {
	Version  string            `json:"version"`
	Features []string          `json:"features"`
	Bodies   []bodyDescription `json:"bodies"`
}

type bodyDescription struct {
	Name        string            `json:"name"`
	Vertices    uint64            `json:"vertices,string"`
	Cells       uint64            `json:"cells,string"`
	Begin       double            `json:"begin"`
	End         double            `json:"end"`
	Min         []double          `json:"min"`
	Max         []double          `json:"max"`
	Hypervolume double            `json:"hypervolume"`
	Slabs       []slabDescription `json:"slabs"`
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
	Domain     string `json:"domain"`
	Name       string `json:"name"`
	Type       uint8  `json:"type,string"`
	Components uint8  `json:"components,string"`
	Checksum   string `json:"checksum"`
}

// describe reads everything.
func describe(f *file) description {
	slabs := map[uint32][]slabDescription{}
	hypervolumes := map[uint32]float64{}
	c := scan(f, func(s *slab) {
		slabs[s.body] = append(slabs[s.body], s.describe())
		hypervolumes[s.body] += s.hypervolume()
	})
	version := fmt.Sprintf("%d.%d", le.Uint16(f.header[8:]), le.Uint16(f.header[10:]))
	d := description{Version: version, Features: c.head.features}
	for i, said := range c.bodies {
		b := bodyDescription{
			Name: c.head.bodies[i], Vertices: said.vertices, Cells: said.cells,
			Begin: double(said.begin), End: double(said.end),
			Hypervolume: double(hypervolumes[uint32(i)]), Slabs: slabs[uint32(i)],
		}
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
			domainNames[a.domain], a.name, a.kind, a.components, fmt.Sprintf("%08x", checksum(a.data)),
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
