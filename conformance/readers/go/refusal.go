package main

import (
	"fmt"
	"runtime"
	"sync"
	"sync/atomic"
)

// A refusal says why a file is refused. The code that parses panics with it, and attempt turns it into
// an error; every other panic is a fault of this program.
type refusal struct{ error }

func refuse(format string, arguments ...any) {
	panic(refusal{fmt.Errorf(format, arguments...)})
}

// require refuses the file unless ok: it breaks the rule of the specification at a byte.
func require(ok bool, offset uint64, rule, what string) {
	if !ok {
		refuse("byte %d: %s: %s", offset, rule, what)
	}
}

func attempt(read func()) (err error) {
	defer func() {
		switch caught := recover().(type) {
		case nil:
		case refusal:
			err = caught.error
		default:
			panic(caught)
		}
	}()
	read()
	return nil
}

// parallel calls do(0) to do(n-1) on all processors, and refuses the file if one of them does.
func parallel(n int, do func(i int)) {
	errors := make([]error, n)
	var next int64 = -1
	var group sync.WaitGroup
	work := func() {
		defer group.Done()
		for i := int(atomic.AddInt64(&next, 1)); i < n; i = int(atomic.AddInt64(&next, 1)) {
			errors[i] = attempt(func() { do(i) })
		}
	}
	for workers := 0; workers < n && workers < runtime.GOMAXPROCS(0); workers++ {
		group.Add(1)
		go work()
	}
	group.Wait()
	for _, err := range errors {
		if err != nil {
			panic(refusal{err})
		}
	}
}
