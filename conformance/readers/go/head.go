package main

import (
	"encoding/json"
	"math"
	"strings"
	"unicode/utf8"
)

// A head is the HEAD of a file.
type head struct {
	features []string
	bodies   []string // their names
	grid     grid
	bytes    []byte
}

// A grid says what positions of type 6 mean.
type grid struct {
	origin [3]float64
	step   float64
}

type object = map[string]any

var knownFeatures = map[string]bool{"zstd": true, "means": true, "pose": true, "grid": true}

func (h *head) has(feature string) bool {
	for _, f := range h.features {
		if f == feature {
			return true
		}
	}
	return false
}

// parseHead parses the payload of HEAD, which is at an offset in the file. Member names are looked up in
// maps, since package json ignores the case of those that it matches with fields of a struct.
func parseHead(data []byte, offset uint64) (h head) {
	demand := func(ok bool, rule, what string) { require(ok, offset, rule, what) }
	demand(len(data) <= 16<<20, "M1", "HEAD is longer than 16 MiB")
	demand(utf8.Valid(data) && !strings.HasPrefix(string(data), "\ufeff"),
		"M2", "HEAD is not UTF-8 without byte order mark")
	var value any
	if err := json.Unmarshal(data, &value); err != nil {
		demand(false, "M3", "HEAD is not JSON: "+err.Error())
	}
	root, isObject := value.(object)
	demand(isObject, "M3", "HEAD is not a JSON object")
	demand(depth(root) <= 64, "M4", "HEAD is nested too deep")

	h = head{features: []string{}, bytes: data}
	features, ok := root["features"].([]any)
	demand(ok, "M5", "features is not an array")
	for _, f := range features {
		name, ok := f.(string)
		demand(ok, "M5", "a feature is not a string")
		demand(knownFeatures[name],
			"M6", "the file needs the feature "+name+", which this reader does not know")
		h.features = append(h.features, name)
	}
	bodies, ok := root["bodies"].([]any)
	demand(ok && len(bodies) >= 1 && len(bodies) <= 65536,
		"M7", "bodies is not an array of 1 to 65,536")
	parents := map[string]any{}
	for _, b := range bodies {
		body, ok := b.(object)
		demand(ok, "M7", "a body is not an object")
		name, ok := body["name"].(string)
		demand(ok && isName(name), "M8", "the name of a body is none")
		_, used := parents[name]
		demand(!used, "M9", "two bodies have the same name")
		parents[name] = body["parent"]
		h.bodies = append(h.bodies, name)
		demand(optional(body, "color", isColor) && optional(body, "material", is[string]) &&
			optional(body, "parent", is[string]) && optional(body, "details", is[object]),
			"M11", "a member of a body is not as it must be")
	}
	requireForest(parents, offset)
	for _, member := range []string{"generator", "backend", "length_unit", "time_unit"} {
		demand(optional(root, member, is[string]), "M10", member+" is not a string")
	}
	demand(optional(root, "up", func(v any) bool { return v == "y" || v == "z" }),
		"M10", "up is neither y nor z")
	demand(optional(root, "details", is[object]), "M10", "details is not an object")
	demand(optional(root, "grid", h.grid.parse), "M10", "grid is not a grid")
	demand(h.grid.step > 0 || !h.has("grid"), "M10", "there is no grid")
	return h
}

func is[T any](value any) bool {
	_, ok := value.(T)
	return ok
}

// optional tells whether a member is right, or not there.
func optional(o object, member string, right func(any) bool) bool {
	value, there := o[member]
	return !there || right(value)
}

func isColor(value any) bool {
	color, _ := value.([]any)
	for _, c := range color {
		if number, ok := c.(float64); !ok || number < 0 || number > 1 {
			return false
		}
	}
	return len(color) == 3 || len(color) == 4
}

func (g *grid) parse(value any) bool {
	o, _ := value.(object)
	origin, _ := o["origin"].([]any)
	if len(origin) != 3 {
		return false
	}
	for i := range origin {
		number, ok := origin[i].(float64)
		if !ok {
			return false
		}
		g.origin[i] = number
	}
	g.step, _ = o["step"].(float64)
	return g.step > 0 && !math.IsInf(g.step, 0)
}

// requireForest demands that the parents of bodies are bodies, and no body a part of itself.
func requireForest(parents map[string]any, offset uint64) {
	done := map[string]bool{}
	for name := range parents {
		seen := map[string]bool{}
		for !done[name] {
			require(!seen[name], offset, "M11", "a body is a part of itself")
			seen[name] = true
			parent, ok := parents[name].(string)
			if !ok {
				break
			}
			_, there := parents[parent]
			require(there, offset, "M11", "a parent is not a body of the file")
			name = parent
		}
		for name := range seen {
			done[name] = true
		}
	}
}

func depth(value any) int {
	deepest := 0
	inside := func(v any) {
		if d := depth(v); d > deepest {
			deepest = d
		}
	}
	switch v := value.(type) {
	case object:
		for _, member := range v {
			inside(member)
		}
	case []any:
		for _, element := range v {
			inside(element)
		}
	default:
		return 0
	}
	return deepest + 1
}

// isName tells whether a text can be the name of a body or an attribute.
func isName(text string) bool {
	forbidden := func(r rune) bool {
		return r < 0x20 || r >= 0x7f && r <= 0x9f || r == '/' || r == 0x61c || r == 0x200e || r == 0x200f ||
			r >= 0x202a && r <= 0x202e || r >= 0x2066 && r <= 0x2069
	}
	return len(text) >= 1 && len(text) <= 255 && utf8.ValidString(text) && strings.IndexFunc(text, forbidden) < 0
}
