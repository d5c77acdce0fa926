// A reader of .t4d files, written from their specification alone: formats/t4d/SPEC.md. It implements
// the appendix "A reader under test".
package main

import (
	"bufio"
	"encoding/json"
	"fmt"
	"math"
	"os"
	"strconv"
	"strings"
)

const usage = "usage: t4d_reader FILE describe | FILE slice T | FILE slice x|y|z C | " +
	"FILE slice A,B,C,D E | --serve"

func main() {
	arguments := os.Args[1:]
	if len(arguments) == 1 && arguments[0] == "--serve" {
		serve()
		return
	}
	if len(arguments) < 2 || !isRequest(arguments[1:]) {
		fmt.Fprintln(os.Stderr, usage)
		os.Exit(2)
	}
	reply, err := answer(arguments[0], arguments[1:])
	if err != nil {
		fmt.Fprintln(os.Stderr, err)
		os.Exit(1)
	}
	fmt.Println(reply)
}

// isRequest tells whether the words ask something of a file; other words say nothing about it.
func isRequest(words []string) bool {
	if len(words) == 1 {
		return words[0] == "describe"
	}
	return attempt(func() { parseHyperplane(words) }) == nil
}

// serve answers a request a line.
func serve() {
	requests := bufio.NewReader(os.Stdin)
	for {
		line, err := requests.ReadString('\n')
		if err != nil {
			return
		}
		reply, err := answer(parseRequest(strings.TrimSuffix(line, "\n")))
		if err != nil {
			fmt.Println("refuse", strings.ReplaceAll(err.Error(), "\n", " "))
		} else {
			fmt.Println("accept", reply)
		}
	}
}

// parseRequest separates the words of a request from the path after them.
func parseRequest(line string) (path string, request []string) {
	words := 1
	if rest := strings.TrimPrefix(line, "slice "); rest != line {
		words = 2
		if first, _, _ := strings.Cut(rest, " "); isAxis(first) || strings.Contains(first, ",") {
			words = 3
		}
	}
	parts := strings.SplitN(line, " ", words+1)
	if len(parts) <= words {
		return "", parts
	}
	return parts[words], parts[:words]
}

// answer is the JSON object for a request about a file.
func answer(path string, request []string) (reply string, err error) {
	err = attempt(func() {
		opened, err := os.Open(path)
		if err != nil {
			panic(refusal{err})
		}
		defer opened.Close()
		var object any
		if len(request) == 1 && request[0] == "describe" {
			object = describe(newFile(opened))
		} else {
			object = slice(newFile(opened), parseHyperplane(request))
		}
		text, err := json.Marshal(object)
		if err != nil {
			panic(err)
		}
		reply = string(text)
	})
	return reply, err
}

// parseHyperplane parses slice T, slice x C or slice A,B,C,D E.
func parseHyperplane(request []string) (h hyperplane) {
	switch {
	case len(request) == 2 && request[0] == "slice":
		return hyperplane{n: unit(3), offset: parseNumber(request[1]), atTime: true}
	case len(request) == 3 && request[0] == "slice":
		h.offset = parseNumber(request[2])
		if copy(h.n[:], normal(request[1])) == 4 && h.n != (point{}) {
			return h
		}
	}
	refuse("%s", usage)
	return h
}

func isAxis(word string) bool { return word == "x" || word == "y" || word == "z" }

// normal is the normal that x, y, z or A,B,C,D stands for, nil for other words.
func normal(word string) []float64 {
	if isAxis(word) {
		n := unit(int(word[0] - 'x'))
		return n[:]
	}
	components := strings.Split(word, ",")
	if len(components) != 4 {
		return nil
	}
	var n point
	for i, c := range components {
		n[i] = parseNumber(c)
	}
	return n[:]
}

func parseNumber(text string) float64 {
	number, err := strconv.ParseFloat(text, 64)
	if err != nil || math.IsInf(number, 0) || math.IsNaN(number) {
		refuse("%s is not a finite number", text)
	}
	return number
}
