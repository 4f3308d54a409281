// Words and tables beside the views.
import { counted, element, grouped, make, measure, set_text } from "./dom";
import { command } from "./export";
import { roles } from "./protocol";
import { layer_count, plane_of, state } from "./state";

const most_rows = 200;
export type Tab = "layer" | "mesh" | "faults" | "islands";
let tab: Tab = "layer";
let shown: unknown[] = [];
let rest = 0, waiting_since = 0;

interface Actions {
    select(contour: number): void;
    go(layer: number): void;
    check(): void;
    unit(mm: number): void;
}
let actions: Actions;

export function begin_panel(given: Actions): void {
    actions = given;
    for (const button of document.querySelectorAll<HTMLButtonElement>("[role=tab]")) {
        button.onclick = () => choose_tab(button.dataset["tab"] as Tab);
    }
}

export function choose_tab(chosen: Tab): void {
    tab = chosen;
    shown = [];
    fill_panel();
}

function button(text: string, action: () => void): HTMLButtonElement {
    const made = make("button", text);
    made.onclick = action;
    return made;
}

/// Rows of text; `pick` makes each a way to something.
function table(heads: string[], rows: (string | number)[][], pick?: (row: number) => void): HTMLTableElement {
    const made = make("table");
    const head = make("tr");
    head.append(...heads.map((text) => make("th", text)));
    made.createTHead().append(head);
    const body = made.createTBody();
    rows.slice(0, most_rows).forEach((cells, r) => {
        const row = make("tr");
        row.append(...cells.map((cell) => make("td", String(cell), typeof cell === "number" || /^-?[\d,.]+$/.test(cell) ? "number" : "")));
        if (pick !== undefined) {
            row.tabIndex = 0;
            row.onclick = () => pick(r);
            row.onkeydown = (event) => event.key === "Enter" && (pick(r), event.stopPropagation());
        }
        body.append(row);
    });
    if (rows.length > most_rows) {
        made.createCaption().textContent = `The first ${most_rows} of ${grouped(rows.length)}: the CSV file has all.`;
    }
    return made;
}

function layer_rows(): (string | number)[][] {
    const layer = state.layer!, parts = state.mesh!.parts.length > 1;
    const rows: (string | number)[][] = [];
    for (let c = 0; c < layer.ends.length; ++c) {
        const [role, part, parent, points, length, area] = layer.rows.subarray(6 * c, 6 * c + 6);
        const within = parent! < 0 ? "" : String(parent);
        rows.push([c, roles[role!]! + (parts ? `, ${state.mesh!.parts[part!]}` : ""), within, grouped(points!), measure(length!), measure(area!)]);
    }
    return rows;
}

function mesh_rows(): [string, string][] {
    const mesh = state.mesh!;
    const size = mesh.max.map((max, axis) => measure(Math.round((max - mesh.min[axis]!) * 1e4) / 1e4)).join(" x ");
    return [
        ["file", state.name], ["format", mesh.format], ["triangles", grouped(mesh.triangles)], ["size", `${size} mm`],
        ["from", mesh.min.map((mm) => measure(mm)).join(", ")], ["parts", mesh.parts.slice(0, 20).join(", ") || "none named"],
        ["gaps", state.gaps || "not yet known"], ["hash", state.hash || "not yet known"], ["at a terminal", command()],
        ...(state.triangles !== null && state.triangles.length / 9 < mesh.triangles
            ? [["3D view", `reduced to ${grouped(state.triangles.length / 9)} triangles; layers are of the mesh itself`] as [string, string]] : []),
        ...mesh.warnings.map((line): [string, string] => ["warning", line.replaceAll("/mesh/", "")]),
    ];
}

function unit_choice(): HTMLElement {
    const label = make("label", "Unit, as the file states none "), choice = make("select");
    for (const [name, mm] of [["mm", 1], ["um", 0.001], ["cm", 10], ["m", 1000], ["inch", 25.4], ["foot", 304.8]] as const) {
        const option = make("option", name);
        option.value = String(mm);
        option.selected = Math.abs(mm - state.mesh!.mm_per_unit) < 1e-9;
        choice.append(option);
    }
    choice.onchange = () => actions.unit(Number(choice.value));
    label.append(choice);
    return label;
}

function content(): HTMLElement[] {
    if (state.mesh === null) {
        return [make("p", "No mesh is open.")];
    }
    if (tab === "mesh") {
        return [table(["", ""], mesh_rows()), ...(state.mesh.states_unit ? [] : [unit_choice()])];
    }
    if (tab === "faults") {
        if (state.checked === null) {
            return state.checking ? [make("p", "Looking for faults ... Esc stops it.")]
                                  : [make("p", "Not looked for yet."), button("Look for faults", actions.check)];
        }
        const found = state.checked.faults.filter(({ count }) => count > 0);
        return [make("p", `The mesh is ${state.checked.verdict}.`), ...(found.length > 0 ? [table(["fault", "places"], found.map(({ name, count }) => [name, grouped(count)]))] : [])];
    }
    if (tab === "islands") {
        const rows = state.islands.map(({ layer, x, y, area }) => [layer, measure(plane_of(layer)), measure(x), measure(y), measure(area)]);
        const unknown = state.islands_unknown > 0 ? ` Not known in ${counted(state.islands_unknown, "layer")} with open contours.` : "";
        const done = state.islands_upto >= layer_count() ? "" : ` (${Math.floor((100 * state.islands_upto) / layer_count())} % searched)`;
        return [make("p", `${counted(rows.length, "island")} with nothing below${done}.${unknown}`),
            ...(rows.length > 0 ? [table(["layer", "mm", "x mm", "y mm", "mm2"], rows, (row) => actions.go(state.islands[row]!.layer))] : [])];
    }
    return state.layer === null ? [] : [table(["contour", "role", "within", "points", "mm", "mm2"], layer_rows(), actions.select)];
}

function facts(): unknown[] {
    return tab === "layer" ? [tab, state.layer] : tab === "mesh" ? [tab, state.mesh, state.hash, state.plan, state.triangles]
        : tab === "faults" ? [tab, state.mesh, state.checked, state.checking]
        : [tab, state.islands.length, state.islands_upto >= layer_count() || Math.floor((10 * state.islands_upto) / layer_count()), state.islands_unknown];
}

function fill_panel(): void {
    waiting_since = 0;
    const now = facts();
    if (now.length === shown.length && now.every((fact, i) => fact === shown[i])) {
        return;
    }
    shown = now;
    element("panel").replaceChildren(...content());
    for (const one of document.querySelectorAll<HTMLButtonElement>("[role=tab]")) {
        one.ariaSelected = String(one.dataset["tab"] === tab);
    }
}

const area_words = (index: number) =>
    index >= state.swept ? "..." : state.sums[4 * index + 3]! > 0 ? "area not known: open" : measure(state.sums[4 * index]!, " mm\u00b2");

function status(): string {
    if (state.layer === null) {
        return "";
    }
    const count = state.layer.ends.length, { rows } = state.layer;
    let holes = 0, open = 0;
    for (let c = 0; c < count; ++c) {
        holes += rows[6 * c] === 1 ? 1 : 0;
        open += rows[6 * c] === 3 ? 1 : 0;
    }
    const hash = state.hash !== "" ? `hash ${state.hash}` : `slicing, ${Math.floor((100 * state.swept) / layer_count())} %`;
    const times = `slice ${state.layer.ms.toFixed(1)} ms, draw ${state.draw_ms.toFixed(1)} ms`;
    const below = state.below !== null && state.below.seq === state.layer.seq && state.overhang > 0 ? ` | overhang ${measure(state.below.area, " mm\u00b2")}` : "";
    return `${counted(count, "contour")}, ${counted(holes, "hole")}, ${open} open${below} | ${times} | ${hash}`;
}

function under_pointer(): string {
    if (state.pointer === null || state.mesh === null) {
        return "";
    }
    const middle = [0, 1].map((axis) => (state.mesh!.min[axis]! + state.mesh!.max[axis]!) / 2);
    const place = `(${(state.pointer[0] + middle[0]!).toFixed(3)}, ${(state.pointer[1] + middle[1]!).toFixed(3)}) mm`;
    const contour = state.hovered >= 0 ? state.hovered : state.selected;
    if (state.layer === null || contour < 0 || contour >= state.layer.ends.length) {
        return place;
    }
    const [role, , , points, length, area] = state.layer.rows.subarray(6 * contour, 6 * contour + 6);
    return `${place}  contour ${contour}: ${roles[role!]}, ${grouped(points!)} points, ${measure(length!, " mm")}, ${measure(area!, " mm\u00b2")}`;
}

function notice(): string {
    if (state.error !== "") {
        return state.error;
    }
    if (state.busy !== "") {
        return `${state.busy} ${state.fraction > 0 ? `${Math.floor(100 * state.fraction)} %` : ""} (Esc stops it)`;
    }
    const first = state.hash === "" ? -1 : first_open();
    if (state.notice === "" && first >= 0) {
        return `The mesh is open: ${state.open}.`;
    }
    return state.notice;
}

export function first_open(): number {
    for (let i = 0; i < state.swept; ++i) {
        if (state.sums[4 * i + 3]! > 0) {
            return i;
        }
    }
    return -1;
}

export function draw_words(): void {
    const count = layer_count();
    document.body.classList.toggle("empty", state.mesh === null);
    set_text("mesh", state.mesh === null ? "" : `${grouped(state.mesh.triangles)} triangles, ${state.mesh.format}`);
    set_text("area", count > 0 ? area_words(state.index) : "");
    set_text("of", count > 0 ? `of ${grouped(count)}` : "");
    set_text("status", status());
    set_text("under", under_pointer());
    set_text("notice", notice());
    element("notice").className = state.error !== "" ? "error" : "";
    element("to-open").hidden = state.error !== "" || state.busy !== "" || state.notice !== "" || state.hash === "" || first_open() < 0;
    set_text("tab-islands", state.islands.length > 0 ? `Islands ${grouped(state.islands.length)}` : "Islands");
    const faults = state.checked?.faults.reduce((sum, { count: more }) => sum + more, 0) ?? 0;
    set_text("tab-faults", faults > 0 ? `Faults ${grouped(faults)}` : "Faults");
    for (const [id, value] of [["z", count > 0 ? measure(plane_of(state.index)) : ""], ["index", count > 0 ? String(state.index) : ""]] as const) {
        const input = element<HTMLInputElement>(id);
        if (document.activeElement !== input && input.value !== value) {
            input.value = value;
        }
    }
    // A table of hundreds of rows takes longer than a frame: it comes when nothing moves, or twice a second.
    const now = performance.now();
    waiting_since = waiting_since || now;
    clearTimeout(rest);
    rest = setTimeout(fill_panel, Math.max(0, Math.min(120, waiting_since + 500 - now)));
}
