meta:
  id: t4d
  title: .t4d 4D mesh, version 1.1
  file-extension: t4d
  license: Apache-2.0
  ks-version: 0.11
  encoding: UTF-8
  endian: le
doc: |
  A `.t4d` file holds 4D meshes: each is the boundary of a moving solid in space-time (x, y, z, t),
  made of tetrahedra and cut into slabs in time order. SPEC.md beside this file is the
  specification; where the two differ, SPEC.md applies.

  Two ways in:

  * From the front: `header`, then `chunks`, one after the other.
  * By index, where `header.has_index`: `footer`, from there `index_chunk` and `done_chunk`. INDX has
    the headers of all chunks, so their offsets and sizes; a `chunk` is parsed there, from the file at
    that offset or from a buffer that holds nothing but it.

  All but `header` are instances, so that nothing is read before it is asked for. The types `chunk`,
  `file_header` and `file_footer` need no root and can be used alone.

  `-rule` names the rule of SPEC.md that a `valid` or `contents` checks. An attribute named
  `end_of_...` takes no bytes; it holds what can be checked only there, mostly that no bytes are
  left. Reading past the end of the fields breaks the rule that says how they end (N11, L4, K4, S9, D4,
  I8). Lengths are held against what is left of the stream before they are used: some runtimes cut
  them to 32 bits.

  What a grammar cannot say is left to whoever uses it:

  * checksums (H2, C4, C5, C10, F2), the length, places and checksum in the footer (F3 to F6);
  * the order and number of chunks (O1 to O6), unknown critical chunks (C8), the critical bit of
    private chunks;
  * codecs 1 and 2 (A10 to A15), UTF-8 (M2, T4), JSON (M3 to M10);
  * whatever compares numbers of several chunks or rows (T6, T7, N2, N4 to N9, N12, L2 for type 6, K2, K5, K6, S2 to S4, S7,
    S8, S10, S12, P1 to P5, D1, D2, D5 to D8, I1 to I6).
doc-ref: SPEC.md

seq:
  - id: header
    type: file_header

instances:
  chunks:
    doc: All chunks from the front, up to INDX, or to DONE in a file without index.
    pos: 24
    type: chunk
    repeat: until
    repeat-until: '_.header.type.text == (header.has_index ? "INDX" : "DONE")'
  footer:
    pos: _io.size - 40
    type: file_footer
    if: header.has_index
  index_chunk:
    pos: footer.ofs_index
    type: chunk
    if: header.has_index
  done_chunk:
    pos: footer.ofs_done
    type: chunk
    if: header.has_index

types:

  file_header:
    doc-ref: SPEC.md, "File header"
    seq:
      - id: signature
        contents: [0x89, T4D, 0x0d, 0x0a, 0x1a, 0x0a]
        -rule: H1
      - id: version_major
        type: u2
        valid: 1
        -rule: H3
      - id: version_minor
        type: u2
      - id: flags
        type: u4
        valid:
          expr: _ <= 1
        -rule: H4
        doc: Bit 0 says that the file has an index; the other bits are reserved.
      - id: reserved
        contents: [0, 0, 0, 0]
        -rule: H5
      - id: checksum
        type: u4
        doc: CRC-32C of bytes 0 to 19 (H2).
    instances:
      has_index:
        value: flags == 1

  file_footer:
    doc: The last 40 bytes of a file with index.
    doc-ref: SPEC.md, "Footer"
    seq:
      - id: ofs_index
        type: u8
      - id: ofs_done
        type: u8
      - id: len_file
        type: u8
      - id: index_checksum
        type: u4
        doc: The header checksum of INDX (F6).
      - id: checksum
        type: u4
        doc: CRC-32C of bytes 0 to 27 of the footer (F2).
      - id: end_signature
        contents: [0x0a, 0x1a, 0x0a, 0x0d, D4T, 0x89]
        -rule: F1

  chunk:
    doc-ref: SPEC.md, "Chunks"
    seq:
      - id: header
        type: chunk_header
      - id: header_checksum
        type: u4
        valid:
          expr: >-
            header.len_payload <= _io.size - _io.pos
            and header.len_padding <= _io.size - _io.pos - header.len_payload
        -rule: C3
        doc: |
          CRC-32C of `header` (C4). The rule is about what follows: payload and padding are inside the
          file.
      - id: table
        type: block_entry
        repeat: expr
        repeat-expr: header.num_blocks
      - id: fields
        size: header.len_front - 8 * header.num_blocks
        type:
          switch-on: header.type.text
          cases:
            '"HEAD"': head
            '"CONN"': conn
            '"LAYR"': layr
            '"POSE"': pose
            '"SLAB"': slab
            '"DONE"': done
            '"INDX"': indx
        doc: Those of an unknown type are left as bytes.
      - id: contents
        size: header.len_payload - header.len_front
        type: blocks
      - id: padding
        type: u1
        repeat: expr
        repeat-expr: header.len_padding
        valid: 0
        -rule: C6

  block_entry:
    seq:
      - id: len_block
        type: u4
        doc: In bytes, without padding.
      - id: checksum
        type: u4
        doc: CRC-32C of the block, without padding (C10).

  blocks:
    doc: The contents of the arrays whose records are among the fields.
    seq:
      - id: blocks
        type: 'block(_index == 0 ? 0 : blocks[_index - 1].end, _parent.table[_index].len_block)'
        repeat: expr
        repeat-expr: _parent.header.num_blocks
      - id: end_of_blocks
        size: 0
        valid:
          expr: _io.eof
        -rule: C9

  block:
    params:
      - id: begin
        type: u8
        doc: From the end of the fields.
      - id: len_data
        type: u4
    seq:
      - id: begin_of_data
        size: 0
        valid:
          expr: end <= _io.size
        -rule: C9
      - id: data
        size: len_data
      - id: padding
        type: u1
        repeat: expr
        repeat-expr: (8 - len_data % 8) % 8
        valid: 0
        -rule: C6
    instances:
      end:
        value: begin + len_data + (8 - len_data % 8) % 8

  chunk_header:
    doc: Without its checksum, as INDX repeats it.
    seq:
      - id: type
        type: chunk_type
        size: 4
      - id: flags
        type: u4
        valid:
          expr: _ <= 1
        -rule: C2
      - id: len_payload
        type: u8
        doc: In bytes, without padding.
      - id: len_front
        type: u4
        valid:
          max: len_payload
        -rule: C9
        doc: The payload before its blocks, in bytes.
      - id: num_blocks
        type: u4
        valid:
          expr: '_ == 0 ? len_front == len_payload : len_front % 8 == 0 and _ <= len_front / 8'
        -rule: C9
      - id: front_checksum
        type: u4
        doc: CRC-32C of the front (C5).
      - id: end_of_header
        size: 0
        valid:
          expr: is_critical or not is_known
        -rule: C7
      - id: end_of_num_blocks
        size: 0
        valid:
          expr: num_blocks == 0 or (type.text != "HEAD" and type.text != "DONE")
        -rule: C11
    instances:
      is_critical:
        value: flags == 1
        doc: A reader must refuse the file if it does not know the type (C8).
      is_known:
        value: >-
          type.text == "HEAD" or type.text == "CONN" or type.text == "LAYR" or type.text == "POSE"
          or type.text == "SLAB" or type.text == "DONE" or type.text == "INDX"
      len_padding:
        value: (8 - len_payload % 8) % 8
      len_chunk:
        value: 32 + len_payload + len_padding
        doc: The distance to the next chunk. May overflow unless `len_payload` has been checked.

  chunk_type:
    seq:
      - id: characters
        type: u1
        repeat: expr
        repeat-expr: 4
        valid:
          expr: >-
            (_ >= 0x41 and _ <= 0x5a) or (_ >= 0x30 and _ <= 0x39 and _index > 0)
            or (_ >= 0x61 and _ <= 0x7a and (_index == 0 or characters[0] >= 0x61))
        -rule: C1
        doc: An uppercase letter and then these and digits, or a lowercase letter and then any.
    instances:
      text:
        pos: 0
        size: 4
        type: str
        encoding: ASCII

  array_record:
    doc: Rows of a fixed number of scalars of one type, whose contents are in blocks of the chunk.
    doc-ref: SPEC.md, "Arrays"
    params:
      - id: chunk
        type: chunk
      - id: first_block
        type: u8
        doc: The number of its first block in the chunk.
    seq:
      - id: scalar_type
        type: u1
        enum: scalar_type
        valid:
          in-enum: true
        -rule: A1
      - id: num_components
        type: u1
        valid:
          min: 1
        -rule: A2
      - id: codec
        type: u1
        enum: codec
        valid:
          in-enum: true
        -rule: A3
      - id: reserved
        contents: [0, 0, 0, 0, 0]
        -rule: A4
      - id: num_rows
        type: u8
        valid:
          expr: _ != 0 or codec == codec::raw
        -rule: A6
      - id: end_of_num_rows
        size: 0
        valid:
          expr: end_block <= chunk.header.num_blocks
        -rule: A5
      - id: end_of_record
        size: 0
        valid:
          expr: codec != codec::repeats or scalar_type == scalar_type::u32
        -rule: A8
      - id: blocks
        type: array_block(_index)
        repeat: expr
        repeat-expr: num_blocks
        doc: Takes no bytes.
    instances:
      num_blocks:
        value: 'num_rows / 65536 + (num_rows % 65536 == 0 ? 0 : 1)'
      end_block:
        value: first_block + num_blocks
        doc: The number of the first block of the next array.
      len_scalar:
        value: >-
          scalar_type.to_i <= 2 ? 1 : scalar_type.to_i <= 4 ? 2 :
          (scalar_type.to_i <= 6 or scalar_type == scalar_type::f32) ? 4 : 8
      len_row:
        value: num_components * len_scalar
        doc: In bytes.

  array_block:
    doc: A block of an array, up to 65,536 rows.
    params:
      - id: index
        type: u4
    seq:
      - id: end_of_raw
        size: 0
        valid:
          expr: _parent.codec != codec::raw or len_stored == len_rows
        -rule: A7
      - id: end_of_stored
        size: 0
        valid:
          expr: (len_rows + 1023) / 1024 <= len_stored
        -rule: A9
    instances:
      number:
        value: _parent.first_block + index
        doc: In the chunk.
      num_rows:
        value: 'index < _parent.num_rows / 65536 ? 65536 : _parent.num_rows % 65536'
      len_rows:
        value: num_rows * _parent.len_row
        doc: In bytes.
      len_stored:
        value: _parent.chunk.table[number].len_block
      stored:
        value: _parent.chunk.contents.blocks[number].data
        doc: |
          Codec 0: the rows, one after another; `raw` has their numbers. Codec 1: one Zstandard frame;
          its content is the rows transposed: byte j of row i is byte j x num_rows + i of the content.
          Codec 2: one Zstandard frame; its content is, for each number, how many places before it the
          same number stands, likewise transposed, then the other numbers. Decoded, they can be
          parsed as `scalars`.
      raw:
        io: _parent.chunk.contents._io
        pos: _parent.chunk.contents.blocks[number].begin
        size: len_rows
        type: scalars(_parent.scalar_type, num_rows * _parent.num_components)
        if: _parent.codec == codec::raw

  scalars:
    doc: Numbers without a header, from the beginning of the stream.
    params:
      - id: scalar_type
        type: u1
        enum: scalar_type
      - id: num_values
        type: u8
    instances:
      values:
        pos: 0
        type:
          switch-on: scalar_type
          cases:
            'scalar_type::u8': u1
            'scalar_type::s8': s1
            'scalar_type::u16': u2
            'scalar_type::s16': s2
            'scalar_type::u32': u4
            'scalar_type::s32': s4
            'scalar_type::u64': u8
            'scalar_type::s64': s8
            'scalar_type::f32': f4
            'scalar_type::f64': f8
        repeat: expr
        repeat-expr: num_values

  attribute:
    doc: Named numbers for each vertex or each cell of a slab.
    doc-ref: SPEC.md, "Attributes"
    params:
      - id: chunk
        type: chunk
      - id: first_block
        type: u8
    seq:
      - id: domain
        type: u1
        enum: domain
        valid:
          in-enum: true
        -rule: T1
      - id: reserved
        contents: [0, 0, 0]
        -rule: T2
      - id: len_name
        type: u4
        valid:
          min: 1
          max: 255
        -rule: T3
      - id: name_bytes
        size: len_name
        doc: UTF-8; `name` is its text. How invalid UTF-8 is decoded depends on the language.
      - id: padding
        type: u1
        repeat: expr
        repeat-expr: (8 - len_name % 8) % 8
        valid: 0
        -rule: T5
      - id: values
        type: array_record(chunk, first_block)
    instances:
      name:
        value: name_bytes.to_s("UTF-8")

  head:
    doc: What the file is, one JSON object; head.schema.json describes it.
    doc-ref: SPEC.md, "HEAD"
    seq:
      - id: end_of_head
        size: 0
        valid:
          expr: _io.size <= 16777216
        -rule: M1
      - id: json
        size-eos: true
        doc: UTF-8 without byte order mark.

  conn:
    doc: |
      Everything of a slab except its positions. The vertices of a slab are, in this order: lower
      layer, interior vertices that are stored, means, upper layer.
    doc-ref: SPEC.md, "CONN"
    seq:
      - id: num_vertices
        type: u4
        doc: Of the slab.
      - id: num_lower
        type: u4
        valid:
          max: num_vertices
        -rule: N1
        doc: Vertices of the lower layer.
      - id: num_upper
        type: u4
        valid:
          max: num_vertices - num_lower
        -rule: N1
        doc: Vertices of the upper layer.
      - id: num_means
        type: u4
        valid:
          max: num_vertices - num_lower - num_upper
        -rule: N1
      - id: num_attributes
        type: u4
        valid:
          max: _io.size / 32
        -rule: N11
        doc: Each takes at least 32 bytes.
      - id: num_ranges
        type: u4
        valid:
          max: _io.size / 24
        -rule: N11
      - id: ranges
        type: range
        repeat: expr
        repeat-expr: num_ranges
        doc: Of the vertices that each block of cells needs, if there is more than one.
      - id: cells
        type: array_record(_parent, 0)
        valid:
          expr: _.scalar_type == scalar_type::u32 and _.num_components == 4
        -rule: N3
        doc: Four indices of vertices of the slab, from 0.
      - id: end_of_cells
        size: 0
        valid:
          expr: 'num_ranges == (cells.num_blocks > 1 ? cells.num_blocks : 0)'
        -rule: N2
      - id: mean_sizes
        type: array_record(_parent, cells.end_block)
        if: num_means > 0
        valid:
          expr: _.scalar_type == scalar_type::u32 and _.num_components == 1 and _.num_rows == num_means
        -rule: N6
        doc: How many sources each mean has.
      - id: mean_sources
        type: array_record(_parent, mean_sizes.end_block)
        if: num_means > 0
        valid:
          expr: _.scalar_type == scalar_type::u32 and _.num_components == 1
        -rule: N6
        doc: The sources of all means, those of the first mean first.
      - id: attributes
        type: 'attribute(_parent, _index == 0 ? attribute_block : attributes[_index - 1].values.end_block)'
        repeat: expr
        repeat-expr: num_attributes
        valid:
          expr: _.domain == domain::cell
        -rule: N10
      - id: end_of_conn
        size: 0
        valid:
          expr: >-
            _io.eof and _parent.header.num_blocks
            == (num_attributes == 0 ? attribute_block : attributes.last.values.end_block)
        -rule: N11
    instances:
      attribute_block:
        value: 'num_means == 0 ? cells.end_block : mean_sources.end_block'
      num_stored:
        value: num_vertices - num_lower - num_upper - num_means
        doc: Interior vertices that are not means; the SLAB has their positions and times.

  range:
    doc: |
      Numbers of vertices of each part of a slab, the first and one more than the last; 0 and 0 if there
      are none.
    seq:
      - id: lower
        type: u4
        repeat: expr
        repeat-expr: 2
      - id: interior
        type: u4
        repeat: expr
        repeat-expr: 2
      - id: upper
        type: u4
        repeat: expr
        repeat-expr: 2

  layr:
    doc: The vertices of one layer.
    doc-ref: SPEC.md, "LAYR"
    seq:
      - id: time
        type: f8
        valid:
          expr: _ - _ == 0
        -rule: L1
        doc: Of all these vertices. The difference is 0 for every finite number, and NaN otherwise.
      - id: num_attributes
        type: u4
        valid:
          max: _io.size / 32
        -rule: L4
        doc: Each takes at least 32 bytes.
      - id: reserved
        contents: [0, 0, 0, 0]
        -rule: L6
      - id: positions
        type: array_record(_parent, 0)
        valid:
          expr: >-
            (_.scalar_type == scalar_type::s32 or _.scalar_type == scalar_type::f32
            or _.scalar_type == scalar_type::f64) and _.num_components == 3
        -rule: L2
      - id: end_of_positions
        size: 0
        valid:
          expr: positions.num_rows > 0
        -rule: L3
      - id: attributes
        type: 'attribute(_parent, _index == 0 ? positions.end_block : attributes[_index - 1].values.end_block)'
        repeat: expr
        repeat-expr: num_attributes
        valid:
          expr: _.domain == domain::vertex
        -rule: L5
      - id: end_of_layr
        size: 0
        valid:
          expr: >-
            _io.eof and _parent.header.num_blocks
            == (num_attributes == 0 ? positions.end_block : attributes.last.values.end_block)
        -rule: L4

  pose:
    doc: A layer that is another one, moved.
    doc-ref: SPEC.md, "POSE"
    seq:
      - id: time
        type: f8
        valid:
          expr: _ - _ == 0
        -rule: K1
      - id: distance_layer
        type: u8
        doc: How many bytes before this chunk its LAYR begins.
      - id: matrix
        type: f8
        repeat: expr
        repeat-expr: 12
        valid:
          expr: _ - _ == 0
        -rule: K3
        doc: Three rows of four numbers, the fourth of each a translation.
      - id: end_of_pose
        size: 0
        valid:
          expr: _io.eof and _parent.header.num_blocks == 0
        -rule: K4

  slab:
    doc: The part of a body between two times.
    doc-ref: SPEC.md, "SLAB"
    seq:
      - id: time_begin
        type: f8
        valid:
          expr: _ - _ == 0
        -rule: S1
      - id: time_end
        type: f8
        valid:
          expr: _ - _ == 0 and _ >= time_begin
        -rule: S1
      - id: distance_connectivity
        type: u8
        doc: How many bytes before this chunk its CONN begins.
      - id: distance_lower
        type: u8
        doc: Likewise a LAYR or a POSE, 0 for an empty layer.
      - id: distance_upper
        type: u8
        doc: Likewise a LAYR or a POSE, 0 for an empty layer.
      - id: body
        type: u4
      - id: num_attributes
        type: u4
        valid:
          max: _io.size / 32
        -rule: S9
        doc: Each takes at least 32 bytes.
      - id: num_bounds
        type: u4
        valid:
          max: _io.size / 64
        -rule: S9
      - id: reserved
        contents: [0, 0, 0, 0]
        -rule: S11
      - id: bounds
        type: f8
        repeat: expr
        repeat-expr: 8 * num_bounds
        doc: |
          Of the vertices of each block of cells, if there is more than one, or left out: minimum of x,
          y, z, t, then maximum.
      - id: positions
        type: array_record(_parent, 0)
        valid:
          expr: >-
            (_.scalar_type == scalar_type::s32 or _.scalar_type == scalar_type::f32
            or _.scalar_type == scalar_type::f64) and _.num_components == 3
        -rule: S5
        doc: Of the interior vertices that are not means.
      - id: times
        type: array_record(_parent, positions.end_block)
        valid:
          expr: >-
            _.scalar_type == scalar_type::f64 and _.num_components == 1
            and _.num_rows == positions.num_rows
        -rule: S6
      - id: attributes
        type: 'attribute(_parent, _index == 0 ? times.end_block : attributes[_index - 1].values.end_block)'
        repeat: expr
        repeat-expr: num_attributes
      - id: end_of_slab
        size: 0
        valid:
          expr: >-
            _io.eof and _parent.header.num_blocks
            == (num_attributes == 0 ? times.end_block : attributes.last.values.end_block)
        -rule: S9

  done:
    doc: The end mark. A file with a valid DONE has all its slabs.
    doc-ref: SPEC.md, "DONE"
    seq:
      - id: num_chunks
        type: u8
        doc: Before this one.
      - id: num_bodies
        type: u4
        valid:
          expr: _io.size % 88 == 16 and _ == _io.size / 88
        -rule: D4
        doc: The fields take 16 + 88 x num_bodies bytes.
      - id: reserved
        contents: [0, 0, 0, 0]
        -rule: D3
      - id: bodies
        type: body
        repeat: expr
        repeat-expr: num_bodies

  body:
    seq:
      - id: num_slabs
        type: u8
        valid:
          min: 1
        -rule: D5
      - id: num_vertices
        type: u8
        doc: Each once, those of all slabs, less the lower layers of all but the first.
      - id: num_cells
        type: u8
      - id: time_begin
        type: f8
      - id: time_end
        type: f8
      - id: minimum
        type: f8
        repeat: expr
        repeat-expr: 3
        doc: Of x, y, z of the stored vertices; +infinity without one.
      - id: maximum
        type: f8
        repeat: expr
        repeat-expr: 3

  indx:
    doc: What a reader needs before it can find a slab, and what it needs to choose one.
    doc-ref: SPEC.md, "INDX"
    seq:
      - id: header
        size: 20
        doc: The file header again, without its checksum.
      - id: num_slabs
        type: u4
      - id: head
        type: array_record(_parent, 0)
        valid:
          expr: _.scalar_type == scalar_type::u8 and _.num_components == 1 and _.codec == codec::raw
        -rule: I7
        doc: The payload of HEAD again.
      - id: chunks
        type: array_record(_parent, head.end_block)
        valid:
          expr: _.scalar_type == scalar_type::u8 and _.num_components == 28
        -rule: I7
        doc: The headers of all chunks before INDX, each a `chunk_header`.
      - id: times
        type: array_record(_parent, chunks.end_block)
        valid:
          expr: _.scalar_type == scalar_type::f64 and _.num_components == 2
        -rule: I7
        doc: Begin and end of each slab, in the order of the file.
      - id: parts
        type: array_record(_parent, times.end_block)
        valid:
          expr: _.scalar_type == scalar_type::u64 and _.num_components == 3
        -rule: I7
        doc: Distances to its connectivity, lower and upper layer.
      - id: bodies
        type: array_record(_parent, parts.end_block)
        valid:
          expr: _.scalar_type == scalar_type::u32 and _.num_components == 1
        -rule: I7
        doc: The number of its body.
      - id: cells
        type: array_record(_parent, bodies.end_block)
        valid:
          expr: _.scalar_type == scalar_type::u64 and _.num_components == 1
        -rule: I7
        doc: The number of its cells.
      - id: bounds
        type: array_record(_parent, cells.end_block)
        valid:
          expr: _.scalar_type == scalar_type::f64 and _.num_components == 6
        -rule: I7
        doc: Minimum of x, y, z of its vertices, then maximum; +infinity and -infinity without one.
      - id: end_of_rows
        size: 0
        valid:
          expr: >-
            times.num_rows == num_slabs and parts.num_rows == num_slabs and bodies.num_rows == num_slabs
            and cells.num_rows == num_slabs and bounds.num_rows == num_slabs
        -rule: I3
      - id: end_of_indx
        size: 0
        valid:
          expr: _io.eof and _parent.header.num_blocks == bounds.end_block
        -rule: I8

enums:

  scalar_type:
    1: u8
    2: s8
    3: u16
    4: s16
    5: u32
    6: s32
    7: u64
    8: s64
    9: f32
    10: f64

  codec:
    0: raw
    1: transposed
    2: repeats

  domain:
    1:
      id: vertex
      doc: A row for each vertex that is stored beside it.
    2:
      id: cell
      doc: A row for each cell of the slab.
