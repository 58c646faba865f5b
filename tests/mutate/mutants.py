"""Finds the mutants of a C file in clang's syntax tree, and writes the file with
all of them inside, each behind a switch. Run alone it tells whether it could."""
import bisect
import re
import sys

sys.path.append("/usr/lib/python3/dist-packages")  # Debian's, for any other python3
import clang.cindex as ci  # noqa: E402

K = ci.CursorKind
T = ci.TypeKind

COMPARISONS = {"<": ("<=", ">="), "<=": ("<", ">"), ">": (">=", "<="), ">=": (">", "<"),
               "==": ("!=",), "!=": ("==",)}
LOGICAL = {"&&": ("||",), "||": ("&&",)}
ARITHMETIC = {"+": ("-",), "-": ("+",), "*": ("/",), "/": ("*",), "%": ("/",),
              "&": ("|",), "|": ("&",), "^": ("|",), "<<": (">>",), ">>": ("<<",)}
BINARY = {**COMPARISONS, **LOGICAL, **ARITHMETIC}
COMPOUND = {op + "=": tuple(to + "=" for to in others) for op, others in ARITHMETIC.items()}
STEPS = {"++": "--", "--": "++"}

INTEGERS = {T.BOOL, T.CHAR_U, T.UCHAR, T.USHORT, T.UINT, T.ULONG, T.ULONGLONG, T.CHAR_S,
            T.SCHAR, T.SHORT, T.INT, T.LONG, T.LONGLONG, T.ENUM}
FLOATS = {T.FLOAT, T.DOUBLE}
WRAPPERS = {K.UNEXPOSED_EXPR, K.PAREN_EXPR}
SIMPLE = {K.BINARY_OPERATOR, K.COMPOUND_ASSIGNMENT_OPERATOR, K.UNARY_OPERATOR, K.CALL_EXPR,
          K.RETURN_STMT, K.BREAK_STMT, K.CONTINUE_STMT}
COMPOSED = {K.IF_STMT, K.FOR_STMT, K.WHILE_STMT, K.DO_STMT, K.SWITCH_STMT}
SHUFFLE = "__builtin_shufflevector("
EYES = 2
EYE_NAMES = {"eye", "e"}
SHOWN = 72
HEAD_SHOWN = 60


class Mutant:
    """A piece of the file, [start, end), and what stands there instead."""

    def __init__(self, start, end, text, where, shown, runtime, form="value"):
        self.start, self.end, self.text = start, end, text
        self.where, self.shown = where, shown
        self.runtime = runtime  # a switch may stand there
        self.form = form        # what it is: a "value", an "object", a "statement"
        self.number = 0

    def apply(self, source):
        return source[:self.start] + self.text + source[self.end:]


class Unparsable(Exception):
    """The file is not C as it stands."""


def normal(text):
    text = re.sub(r"/\*.*?\*/", " ", text, flags=re.S)
    return re.sub(r"\s+", " ", text).strip()


def neighbours(text):
    """The numbers beside a literal's, in its own notation."""
    m = re.fullmatch(r"(0[xX][0-9a-fA-F]+|\d+)([uUlL]*)", text)
    if not m:
        return [f"({text} + 1)", f"({text} - 1)"]
    digits, suffix = m.groups()
    n = int(digits, 0)
    form = f"0x{{:0{len(digits) - 2}x}}{{}}" if digits[:2] in ("0x", "0X") else "{}{}"
    below = form.format(n - 1, suffix) if n > 0 else f"({text} - 1{suffix})"
    return [form.format(n + 1, suffix), below]


def unqualified(t):
    """A type's name, without what its own qualifiers say."""
    t = t.get_canonical()
    if t.kind in (T.CONSTANTARRAY, T.INCOMPLETEARRAY):
        return t.spelling  # those are of its elements
    if t.kind == T.POINTER:
        return re.sub(r"(\s*(const|volatile|restrict))+$", "", t.spelling)
    return re.sub(r"^((const|volatile)\s+)+", "", t.spelling)


class Variable:
    """A parameter or a local variable, where it can be named."""

    def __init__(self, cursor, has_value):
        self.name, self.type = cursor.spelling, unqualified(cursor.type)
        self.is_const = cursor.type.get_canonical().is_const_qualified()
        self.has_value = has_value  # from its declaration on, or since it was named


class Finder:
    def __init__(self, path, arguments):
        self.path = str(path)
        with open(self.path, encoding="latin-1", newline="") as f:
            self.source = f.read()
        self.mutants = []
        self._seen = set()
        self._unit = ci.Index.create().parse(
            self.path, args=["-x", "c", *arguments],
            options=ci.TranslationUnit.PARSE_DETAILED_PROCESSING_RECORD)
        worst = [d for d in self._unit.diagnostics if d.severity >= ci.Diagnostic.Error]
        if worst:
            raise Unparsable(str(worst[0]))
        self._tokens = [t for t in self._unit.get_tokens(extent=self._unit.cursor.extent)
                        if t.kind != ci.TokenKind.COMMENT]
        self._starts = [t.extent.start.offset for t in self._tokens]
        self._macros = sorted(self._span(c) for c in self._unit.cursor.get_children()
                              if c.kind == K.MACRO_INSTANTIATION and self._is_here(c))

    def _is_here(self, cursor):
        f = cursor.extent.start.file
        return f is not None and f.name == self.path

    @staticmethod
    def _span(cursor):
        return cursor.extent.start.offset, cursor.extent.end.offset

    def _text(self, cursor):
        start, end = self._span(cursor)
        return self.source[start:end]

    def _between(self, start, end):
        """The tokens that begin in [start, end)."""
        return self._tokens[bisect.bisect_left(self._starts, start):
                            bisect.bisect_left(self._starts, end)]

    def _macro_of(self, cursor):
        start, end = self._span(cursor)
        at = bisect.bisect_right(self._macros, (start, 1 << 60)) - 1
        if at >= 0 and self._macros[at][0] <= start and end <= self._macros[at][1]:
            return self._macros[at]
        return None

    # What is found.

    def find(self):
        for top in self._unit.cursor.get_children():
            if not self._is_here(top):
                continue
            self._function = top.spelling
            self._chain = []
            self._scopes = [[]]
            if top.kind == K.FUNCTION_DECL and top.is_definition():
                self._result = top.result_type.get_canonical()
                body = list(top.get_children())[-1]
                statements = list(body.get_children())
                self._last = self._span(statements[-1]) if statements else None
                self._scopes = [[Variable(p, True) for p in top.get_arguments() if p.spelling]]
                self._walk(body, True)
            elif top.kind == K.VAR_DECL:
                self._variable(top, True)
        self.mutants.sort(key=lambda m: (m.start, m.end, m.text))
        return self.mutants

    def _add(self, start, end, text, runtime, form="value", shown=None):
        if (start, end, text) in self._seen:
            return
        self._seen.add((start, end, text))
        if shown is None:
            low, high = start, end
            for s, e in reversed(self._chain):
                if s <= start and end <= e and len(normal(self.source[s:e])) <= SHOWN:
                    low, high = min(low, s), max(high, e)
            after = self.source[low:start] + text + self.source[end:high]
            shown = f"{normal(self.source[low:high])} => {normal(after)}"
        self.mutants.append(Mutant(start, end, text, self._function, shown, runtime, form))

    def _constant(self, cursor, runtime):
        start, end = self._span(cursor)
        text = self.source[start:end]
        if text in ("true", "false"):
            self._add(start, end, "false" if text == "true" else "true", runtime)
            return
        before = self._between(0, start)[-2:]
        after = self._between(end, end + 80)[:1]
        if ([t.spelling for t in before[1:]] == ["["] and before[0].spelling in ("{", ",", "]")
                and [t.spelling for t in after] == ["]"]):
            runtime = False  # a designator
        for to in neighbours(text):
            self._add(start, end, to, runtime)

    def _real(self, cursor, runtime):
        start, end = self._span(cursor)
        for to in ("2 *", "0 *"):
            self._add(start, end, f"({to} {self.source[start:end]})", runtime)

    def _is_constant(self, cursor):
        if cursor.type.get_canonical().kind not in INTEGERS:
            return False
        nodes = list(cursor.walk_preorder())
        return all(n.kind in (K.INTEGER_LITERAL, K.CHARACTER_LITERAL, K.BINARY_OPERATOR,
                              K.UNARY_OPERATOR, K.CSTYLE_CAST_EXPR, K.TYPE_REF, *WRAPPERS)
                   or (n.kind == K.DECL_REF_EXPR and n.referenced.kind == K.ENUM_CONSTANT_DECL)
                   for n in nodes)

    def _operator(self, left, right):
        between = self._between(self._span(left)[1], self._span(right)[0])
        return between[0] if len(between) == 1 else None

    def _assigns(self, cursor):
        if cursor.kind != K.BINARY_OPERATOR:
            return False
        op = self._operator(*cursor.get_children())
        return op is not None and op.spelling == "="

    def _bare(self, cursor):
        while cursor.kind in WRAPPERS:
            inner = list(cursor.get_children())
            if len(inner) != 1 or self._macro_of(cursor):
                break
            cursor = inner[0]
        return cursor

    def _negate(self, cursor, runtime):
        """The opposite of a condition that no operator of its own inverts."""
        bare = self._bare(cursor)
        if self._macro_of(bare):
            return
        if bare.kind == K.BINARY_OPERATOR:
            op = self._operator(*bare.get_children())
            if op is None or op.spelling in COMPARISONS or op.spelling in LOGICAL:
                return
        elif bare.kind == K.UNARY_OPERATOR and self._text(bare).startswith("!"):
            return
        elif bare.kind in (K.INTEGER_LITERAL, K.CONDITIONAL_OPERATOR):
            return
        start, end = self._span(cursor)
        self._add(start, end, f"!({self.source[start:end]})", runtime)

    def _binary(self, cursor, runtime):
        left, right = cursor.get_children()
        op = self._operator(left, right)
        if op is None:
            return
        table = COMPOUND if cursor.kind == K.COMPOUND_ASSIGNMENT_OPERATOR else BINARY
        start, end = self._span(cursor)
        at = op.extent.start.offset
        points = [c.type.get_canonical().kind == T.POINTER for c in (left, right)]
        for to in table.get(op.spelling, ()):
            if points[1] and op.spelling in ARITHMETIC and not (points[0] and to == "-"):
                continue  # no such difference
            if points[0] and points[1] and op.spelling == "-":
                continue  # nor such a sum
            self._add(start, end, self.source[start:at] + to
                      + self.source[at + len(op.spelling):end], runtime)
        if op.spelling in LOGICAL:
            self._negate(left, runtime)
            self._negate(right, runtime)

    def _unary(self, cursor, runtime):
        start, end = self._span(cursor)
        text = self.source[start:end]
        if text[:2] in STEPS:
            self._add(start, end, STEPS[text[:2]] + text[2:], runtime)
        elif text[-2:] in STEPS:
            self._add(start, end, text[:-2] + STEPS[text[-2:]], runtime)
        elif text[0] == "!":
            self._add(start, end, f"!!{text[1:]}", runtime)
        elif text[0] in "-~":
            self._add(start, end, f"({text[1:]})", runtime)

    def _return(self, cursor):
        value = next(iter(cursor.get_children()), None)
        if value is None or self._macro_of(value):
            return
        bare = self._bare(value)
        if self._result.kind == T.BOOL:
            self._negate(value, True)
        elif (self._result.kind in INTEGERS or self._result.kind == T.POINTER) and \
                not self._is_constant(bare):
            start, end = self._span(value)
            self._add(start, end, "0", True)

    def _deletion(self, cursor):
        """A statement left out, but the last of a function that has a result."""
        start, end = self._span(cursor)
        if cursor.kind in COMPOSED:
            if (start, end) != self._last or self._result.kind == T.VOID:
                self._leave_out(cursor, start, end)
            return
        following = self._between(end, end + 200)[:1]
        if not following or following[0].spelling != ";":
            return
        end = following[0].extent.end.offset
        if cursor.kind == K.RETURN_STMT and (start, end - 1) == self._last:
            return
        shown = f"delete: {normal(self.source[start:end])}"
        self._add(start, end, ";", True, "statement", shown)

    def _leave_out(self, cursor, start, end):
        head = normal(self.source[start:end].split("{")[0])
        if cursor.kind == K.DO_STMT:
            end = self._between(end, end + 200)[0].extent.end.offset
            head = normal(self.source[start:end].rsplit("}")[-1])
        if len(head) > HEAD_SHOWN:
            head = head[:HEAD_SHOWN].rstrip() + "..."
        self._add(start, end, ";", True, "statement", f"delete all of: {head}")

    def _another_variable(self, cursor, is_read, runtime):
        """Each other one of the same type that could be named here."""
        mine = unqualified(cursor.type)
        used = cursor.referenced
        if used.kind not in (K.VAR_DECL, K.PARM_DECL):
            return
        here = {v.name: v for scope in self._scopes for v in scope}  # the inner hides the outer
        start, end = self._span(cursor)
        for v in here.values():
            if v.name == used.spelling or v.type != mine:
                continue
            if is_read and v.has_value:
                self._add(start, end, v.name, runtime)
            elif not is_read and v.is_const == used.type.is_const_qualified():
                self._add(start, end, v.name, runtime, "object")
        if used.spelling in here:
            here[used.spelling].has_value = True

    def _another_field(self, cursor, is_read, runtime):
        """Each other field of the same struct and type."""
        base = next(iter(cursor.get_children()), None)
        if base is None or cursor.referenced.kind != K.FIELD_DECL:
            return
        struct = base.type.get_canonical()
        struct = struct.get_pointee().get_canonical() if struct.kind == T.POINTER else struct
        start, end = self._span(cursor)
        name = cursor.referenced.spelling
        if not self.source[start:end].endswith(name):
            return
        for f in struct.get_fields():
            if f.spelling != name and not f.is_bitfield() and \
                    unqualified(f.type) == unqualified(cursor.type):
                self._add(start, end, self.source[start:end - len(name)] + f.spelling, runtime,
                          "value" if is_read else "object")

    def _other_eye(self, start, end, runtime):
        """The other one, and one of them for both."""
        for text in (f"(1 - ({self.source[start:end]}))", "0", "1"):
            self._add(start, end, text, runtime)

    def _subscript(self, cursor, runtime):
        base, index = cursor.get_children()
        array = self._bare(base).type.get_canonical()
        if array.kind == T.CONSTANTARRAY and array.element_count == EYES and \
                not self._is_constant(index):
            self._other_eye(*self._span(index), runtime)

    def _reference(self, cursor, is_read, runtime):
        kind = cursor.type.get_canonical().kind
        if cursor.kind == K.DECL_REF_EXPR:
            self._another_variable(cursor, is_read, runtime)
        else:
            self._another_field(cursor, is_read, runtime)
        if is_read and cursor.spelling in EYE_NAMES and kind in INTEGERS:
            self._other_eye(*self._span(cursor), runtime)

    def _variable(self, cursor, is_static):
        """What a variable begins with, and the sizes of arrays: one less, as one
        more makes no difference."""
        start, end = self._span(cursor)
        depth = 0
        begin = None
        for token in self._between(start, end):
            depth += {"[": 1, "]": -1}.get(token.spelling, 0)
            if token.spelling == "=" and depth == 0:
                begin = token.extent.start.offset
                break
        self._chain.append((start, end))
        for child in cursor.get_children():
            if not child.kind.is_expression():
                continue
            if begin is None or self._span(child)[0] < begin:
                low, high = self._span(child)
                self._add(low, high, f"{self.source[low:high]} - 1", False)
            else:
                self._walk(child, not is_static)
        self._chain.pop()

    def _walk(self, cursor, runtime, is_read=False):
        kind = cursor.kind
        if kind.is_expression():
            macro = self._macro_of(cursor)
            if macro is not None:
                if macro == self._span(cursor) and self._is_constant(cursor):
                    self._constant(cursor, runtime)
                return
        if kind == K.CXX_UNARY_EXPR or kind == K.STRUCT_DECL:
            return
        if kind == K.VAR_DECL:
            self._variable(cursor, cursor.storage_class == ci.StorageClass.STATIC)
            has_value = any(c.kind.is_expression() for c in cursor.get_children())
            self._scopes[-1].append(Variable(cursor, has_value))
            return
        shown = kind.is_expression() or kind == K.RETURN_STMT
        if shown:
            self._chain.append(self._span(cursor))
        if kind in (K.DECL_REF_EXPR, K.MEMBER_REF_EXPR):
            self._reference(cursor, is_read, runtime)
        self._look(cursor, runtime)
        opens = kind in (K.COMPOUND_STMT, K.FOR_STMT)
        if opens:
            self._scopes.append([])
        self._descend(cursor, runtime)
        if opens:
            self._scopes.pop()
        if shown:
            self._chain.pop()

    def _look(self, cursor, runtime):
        kind = cursor.kind
        if kind in (K.INTEGER_LITERAL, K.CHARACTER_LITERAL):
            self._constant(cursor, runtime)
        elif kind == K.FLOATING_LITERAL:
            self._real(cursor, runtime)
        elif kind == K.DECL_REF_EXPR and cursor.referenced.kind == K.ENUM_CONSTANT_DECL:
            self._constant(cursor, runtime)
        elif kind in (K.BINARY_OPERATOR, K.COMPOUND_ASSIGNMENT_OPERATOR):
            self._binary(cursor, runtime)
        elif kind == K.UNARY_OPERATOR:
            self._unary(cursor, runtime)
        elif kind == K.RETURN_STMT:
            self._return(cursor)
        elif kind == K.ARRAY_SUBSCRIPT_EXPR:
            self._subscript(cursor, runtime)

    def _descend(self, cursor, runtime):
        kind = cursor.kind
        children = list(cursor.get_children())
        # A value is read where clang converts an object to it.
        is_read = kind == K.UNEXPOSED_EXPR
        if kind in (K.IF_STMT, K.WHILE_STMT, K.CONDITIONAL_OPERATOR):
            self._negate(children[0], runtime)
        elif kind == K.DO_STMT:
            self._negate(children[-1], runtime)
        in_block = kind in (K.COMPOUND_STMT, K.CASE_STMT, K.DEFAULT_STMT)
        if self._assigns(cursor):
            children.reverse()  # the variable has its value afterwards
        constant = self._constants_of(cursor)
        for i, child in enumerate(children):
            if in_block and child.kind in SIMPLE | COMPOSED:
                self._deletion(child)
            self._walk(child, runtime and i not in constant, is_read)

    def _constants_of(self, cursor):
        """Which of its children have to be constant expressions: a label, and what a
        shuffle of vectors takes from where."""
        if cursor.kind == K.CASE_STMT:
            return range(1)
        start = self._span(cursor)[0]
        if cursor.kind == K.UNEXPOSED_EXPR and self.source.startswith(SHUFFLE, start):
            return range(2, sys.maxsize)
        return range(0)


def label(mutants):
    """Numbers them, and makes their names differ within a file."""
    seen = {}
    for number, m in enumerate(mutants, 1):
        m.number = number
        key = (m.where, m.shown)
        seen[key] = seen.get(key, 0) + 1
        m.name = f"{m.where}: {m.shown}" + (f" #{seen[key]}" if seen[key] > 1 else "")


HEAD = """extern int lum_mutant;
extern unsigned char lum_reached[];
#ifdef LUM_REACH
#define LUM_IS(n) (lum_reached[n] = 1, 0)
#else
#define LUM_IS(n) (lum_mutant == (n))
#endif
#line 1
"""


# An object stays one that can be written; the innermost, as the others make values of it.
FORMS = (("object", "(*(LUM_IS({n}) ? &({text}) : &({inner})))"),
         ("value", "(LUM_IS({n}) ? ({text}) : ({inner}))"),
         ("statement", "{{ if (!LUM_IS({n})) {inner} }}"))


def with_switches(source, mutants):
    """The file with every mutant that can be chosen at run time."""
    spans = {}
    for m in mutants:
        if m.runtime:
            spans.setdefault((m.start, m.end), []).append(m)
    order = sorted(spans, key=lambda s: (s[0], -s[1]))
    at = 0

    def render(start, end):
        nonlocal at
        out = []
        here = start
        while at < len(order) and order[at][0] < end:
            span = order[at]
            at += 1
            out.append(source[here:span[0]])
            inner = render(*span)
            group = spans[span]
            for form, to in FORMS:
                for m in group:
                    if m.form == form:
                        inner = to.format(n=m.number, text=m.text, inner=inner)
            out.append(inner)
            here = span[1]
        out.append(source[here:end])
        return "".join(out)

    return HEAD + render(0, len(source))


if __name__ == "__main__":
    try:
        ci.Index.create()
    except ci.LibclangError as e:
        sys.exit(str(e))
