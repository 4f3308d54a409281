import { bytes_of, Client, type Source } from "./client";
import { draw_curve, height_at } from "./curve";
import { element, fit_canvas, forget_colours, make, save, watch_sizes } from "./dom";
import { save_csv, save_png, stem } from "./export";
import { begin_keys } from "./keys";
import { draw_layer, fit, nearest, to_mm, view, zoom, zoom_to } from "./layer";
import { parse_link, plan_of_link, remember } from "./link";
import { begin_panel, draw_words, first_open } from "./panel";
import { gzip, rules, type Answer, type Plan } from "./protocol";
import { Stack } from "./stack";
import { centre, changed, layer_at, layer_count, on_frame, plane_of, state } from "./state";

const most_bytes = 1.6e9; // of a file: the engine has 4 GB of addresses
const checked_at_once = 300_000; // triangles

const layer_canvas = element<HTMLCanvasElement>("layer"), curve_canvas = element<HTMLCanvasElement>("curve");
const stack_canvas = element<HTMLCanvasElement>("stack");
const stack = new Stack(stack_canvas);
const client = new Client(take);
let sources: Source[] = [];
let shown = { sources, which: -1 }; // those of the mesh that is open
let linked: Record<string, number> = parse_link(location.hash);
let below_timer = 0;

// --- answers of the worker

function take(answer: Answer): void {
    switch (answer.say) {
        case "progress": state.fraction = answer.fraction; return;
        case "opened": return opened(answer);
        case "planned": return planned(answer.slabs);
        case "areas":
            state.sums.set(answer.rows, 4 * answer.from);
            state.swept = answer.from + answer.rows.length / 4;
            ({ hash: state.hash, gaps: state.gaps, open: state.open } = answer);
            if (answer.hash !== "") {
                state.show_islands && client.more("islands");
                document.body.dataset["hash"] = answer.hash;
            }
            return;
        case "layer":
            state.layer === null && begin_rest(); // of what takes longer, once there is something to see
            state.layer = answer;
            state.hovered = -1;
            state.selected = state.selected < answer.ends.length ? state.selected : -1;
            document.body.dataset["layer"] = String(answer.index);
            clearTimeout(below_timer);
            below_timer = setTimeout(() => (state.show_islands || state.overhang > 0) && client.below(), 60);
            return;
        case "below": state.below = answer; return;
        case "islands":
            for (let i = 0; i < answer.rows.length; i += 5) {
                const [layer, contour, x, y, area] = answer.rows.subarray(i, i + 5);
                state.islands.push({ layer: layer!, contour: contour!, x: x!, y: y!, area: area! });
            }
            [state.islands_upto, state.islands_unknown] = [answer.upto, answer.unknown];
            return;
        case "preview": state.triangles = answer.triangles; return;
        case "checked": state.checked = answer; return;
        case "svg": return save(`${stem()}.svg`, answer.bytes as Uint8Array<ArrayBuffer>, "image/svg+xml");
        case "failed":
            state.error = answer.message;
            return answer.ask === "open" ? relist() : undefined;
        case "dead": return relist();
    }
}

function opened({ mesh }: Extract<Answer, { say: "opened" }>): void {
    state.mesh = mesh;
    shown = { sources, which: Number(element<HTMLSelectElement>("sources").value) };
    state.triangles = state.checked = state.layer = state.below = null;
    state.slabs = new Float64Array();
    state.height = NaN;
    state.selected = -1;
    view.scale = 0;
    state.notice = mesh.warnings.length > 0 ? mesh.warnings[0]!.replaceAll("/mesh/", "") : "";
    delete document.body.dataset["hash"];
    delete document.body.dataset["layer"];
    client.plan(plan_of_link(linked, state.plan));
}

function begin_rest(): void {
    state.triangles === null && client.more("preview");
    state.checked === null && state.mesh!.triangles <= checked_at_once && client.check();
}

function planned(slabs: Float64Array<ArrayBuffer>): void {
    state.error = "";
    state.slabs = slabs;
    state.sums = new Float64Array(2 * slabs.length);
    [state.swept, state.hash, state.islands, state.islands_upto, state.islands_unknown] = [0, "", [], 0, 0];
    state.below = null;
    state.plan = asked_plan ?? plan_of_link(linked, state.plan);
    delete document.body.dataset["hash"];
    if (slabs.length === 0) {
        state.notice = "The mesh has no layer of this height.";
        state.layer = null;
    }
    const middle = centre();
    const wish = linked["z"] ?? (Number.isNaN(state.height) ? middle[2] : state.height);
    state.index = slabs.length > 0 ? layer_at(wish) : 0;
    if (view.scale === 0) {
        fit(layer_canvas);
        [view.x, view.y, view.scale] = [linked["x"] ?? view.x, linked["y"] ?? view.y, linked["s"] ?? view.scale];
    }
    linked = {};
    asked_plan = null;
    client.forget_layer();
    show_settings();
}

// --- what people do

function open_files(files: Iterable<File>): void {
    const found: Source[] = [...files].map((file) => ({ file, name: file.name, unit: 0 }));
    if (found.length > 0) {
        sources = found;
        choose(0);
    }
}

function choose(which: number): void {
    const source = sources[which]!;
    list_sources(which);
    if (source.file.size > most_bytes) {
        take({ say: "failed", ask: "open", message: `${source.name}: ${(source.file.size / 1e9).toFixed(1)} GB are more than a page can hold (1.6 GB). lamella slice takes it.` });
        changed();
        return;
    }
    client.open(source);
}

/// The mesh that is open, after another could not be opened.
function relist(): void {
    if (shown.which >= 0) {
        sources = shown.sources;
        list_sources(shown.which);
    }
}

function list_sources(which: number): void {
    const list = element<HTMLSelectElement>("sources");
    list.replaceChildren(...sources.map(({ name }, i) => {
        const option = make("option", name);
        option.value = String(i);
        return option;
    }));
    list.value = String(which);
}

function go(index: number): void {
    if (layer_count() > 0) {
        state.index = Math.max(0, Math.min(layer_count() - 1, Math.round(index)));
        state.height = plane_of(state.index);
        remember();
        changed();
    }
}

/// To the next layer up or down where something is: an island with nothing below, or a fault.
function next_place(direction: 1 | -1): void {
    const heights = state.islands.map(({ layer }) => layer);
    const points = state.checked?.points ?? [];
    for (let i = 2; i < points.length; i += 3) {
        heights.push(layer_at(points[i]! + centre()[2]));
    }
    const further = heights.filter((layer) => direction * (layer - state.index) > 0);
    further.length > 0 && go(direction > 0 ? further.reduce((a, b) => Math.min(a, b)) : further.reduce((a, b) => Math.max(a, b)));
}

function select(contour: number): void {
    state.selected = contour;
    changed();
}

function step_contour(step: number): void {
    const count = state.layer?.ends.length ?? 0;
    count > 0 && select((Math.max(state.selected, step > 0 ? -1 : 0) + step + count) % count);
}

// --- settings

const setting = (id: string) => element<HTMLInputElement>(id);
let asked_plan: Plan | null = null;
let plan_timer = 0;

function show_settings(): void {
    const { height, cusp, stitch, closing, rule } = state.plan;
    setting("height").value = String(height);
    setting("adaptive").checked = cusp > 0;
    setting("cusp").disabled = cusp === 0;
    cusp > 0 && (setting("cusp").value = String(cusp));
    setting("stitch").value = stitch === -1 ? "" : String(stitch);
    setting("closing").value = String(closing);
    setting("rule").value = String(rule);
}

function read_settings(): void {
    const number = (id: string) => Number(setting(id).value);
    asked_plan = {
        height: number("height"), cusp: setting("adaptive").checked ? number("cusp") : 0,
        stitch: setting("stitch").value === "" ? -1 : number("stitch"), closing: number("closing"), rule: number("rule"),
    };
    setting("cusp").disabled = !setting("adaptive").checked;
    state.error = "";
    state.mesh === null ? (state.plan = asked_plan) : client.plan(asked_plan);
    changed();
}

function begin_settings(): void {
    const rule = element<HTMLSelectElement>("rule");
    rule.append(...rules.map((name, i) => new Option(name, String(i))));
    show_settings();
    for (const id of ["height", "cusp", "stitch", "closing", "adaptive", "rule"]) {
        setting(id).addEventListener("input", () => {
            clearTimeout(plan_timer);
            plan_timer = setTimeout(read_settings, 120);
        });
    }
    element<HTMLSelectElement>("colour").onchange = (event) => {
        state.colour = (event.target as HTMLSelectElement).value as typeof state.colour;
        stack.forget_cap();
        changed();
    };
    setting("islands").onchange = () => {
        state.show_islands = setting("islands").checked;
        state.show_islands && state.hash !== "" && client.more("islands");
        client.below();
        changed();
    };
    const overhang = () => {
        state.overhang = setting("overhang").checked ? Math.max(1, Math.min(89, Number(setting("degrees").value) || 45)) : 0;
        layer_count() > 0 && client.below();
    };
    setting("overhang").onchange = setting("degrees").onchange = overhang;
}

function jump(text: string): void {
    const number = Number(text.replace("#", "").replace(",", "."));
    if (text.trim() !== "" && Number.isFinite(number) && layer_count() > 0) {
        go(text.trim().startsWith("#") ? number : layer_at(number));
    }
}

// --- pointer

function drag(canvas: HTMLCanvasElement, moved: (dx: number, dy: number, event: PointerEvent) => void): void {
    canvas.addEventListener("pointerdown", (event) => {
        canvas.setPointerCapture(event.pointerId);
        moved(0, 0, event);
    });
    canvas.addEventListener("pointermove", (event) => {
        event.buttons > 0 && canvas.hasPointerCapture(event.pointerId) && moved(event.movementX, event.movementY, event);
        changed();
    });
}

function wheel(canvas: HTMLCanvasElement, turned: (up: boolean, event: WheelEvent) => void): void {
    canvas.addEventListener("wheel", (event) => {
        event.preventDefault();
        state.mesh !== null && event.deltaY !== 0 && turned(event.deltaY < 0, event);
        changed();
    }, { passive: false });
}

function begin_pointer(): void {
    drag(curve_canvas, (_dx, _dy, event) => layer_count() > 0 && go(layer_at(height_at(curve_canvas, event.offsetY))));
    wheel(curve_canvas, (up) => go(state.index + (up ? 1 : -1)));
    drag(layer_canvas, (dx, dy, event) => {
        if (dx === 0 && dy === 0 && event.type === "pointerdown") {
            select(state.hovered);
        }
        view.x -= dx / view.scale;
        view.y += dy / view.scale;
        remember();
    });
    layer_canvas.addEventListener("pointermove", (event) => {
        state.pointer = view.scale > 0 ? to_mm(layer_canvas, event.offsetX, event.offsetY) : null;
    });
    layer_canvas.addEventListener("pointerleave", () => {
        [state.pointer, state.hovered] = [null, -1];
        changed();
    });
    layer_canvas.addEventListener("dblclick", () => state.selected >= 0 && (zoom_to(layer_canvas, state.selected), changed()));
    wheel(layer_canvas, (up, event) => {
        zoom(layer_canvas, up ? 1.2 : 1 / 1.2, event.offsetX, event.offsetY);
        remember();
    });
    drag(stack_canvas, (dx, dy) => stack.turn(dx, dy));
    wheel(stack_canvas, (up) => stack.magnify(up ? 1.15 : 1 / 1.15));
}

// --- page

function set_view(next = ({ both: "layer", layer: "3d", "3d": "both" } as const)[state.view]): void {
    state.view = stack.failed !== "" ? "layer" : next;
    state.notice = stack.failed || state.notice;
    document.body.dataset["view"] = state.view;
    changed();
}

function set_dark(): void {
    const root = document.documentElement, system = matchMedia("(prefers-color-scheme: dark)").matches;
    const dark = root.dataset["theme"] === undefined ? system : root.dataset["theme"] === "dark";
    root.dataset["theme"] = dark ? "light" : "dark";
    forget_colours();
    stack.forget_cap();
    changed();
}

function escape(): void {
    client.cancel();
    state.error = state.notice = "";
    state.selected = -1;
    changed();
}

const dialog = (id: string) => element<HTMLDialogElement>(id).showModal();
const pick = () => element<HTMLInputElement>("file").click();

function toggle(name: "outline" | "fill"): void {
    state[name] = !state[name];
    changed();
}

function begin_page(): void {
    begin_keys([
        { keys: ["ArrowUp", "W"], says: "a layer up", act: () => go(state.index + 1) },
        { keys: ["ArrowDown", "S"], says: "a layer down", act: () => go(state.index - 1) },
        { keys: ["PageUp", "PageDown"], says: "ten layers", act: (key) => go(state.index + (key === "PageUp" ? 10 : -10)) },
        { keys: ["Home", "End"], says: "lowest and highest layer", act: (key) => go(key === "Home" ? 0 : Infinity) },
        { keys: ["G"], says: "type a height, 12.4, or a layer, #124", act: () => element<HTMLInputElement>("z").select() },
        { keys: ["ArrowLeft", "ArrowRight"], says: "next island or fault below, above", act: (key) => next_place(key === "ArrowRight" ? 1 : -1) },
        { keys: ["F"], says: "fit the view", act: () => state.mesh !== null && (fit(layer_canvas), stack.home(), changed()) },
        { keys: ["+", "-"], says: "zoom", act: (key) => state.mesh !== null && (zoom(layer_canvas, key === "+" ? 1.3 : 1 / 1.3), changed()) },
        { keys: ["N", "P"], says: "next and previous contour", act: (key) => step_contour(key === "N" ? 1 : -1) },
        { keys: ["Enter"], says: "zoom to the contour", act: () => state.selected >= 0 && (zoom_to(layer_canvas, state.selected), changed()) },
        { keys: ["L", "A"], says: "outline, fill", act: (key) => toggle(key === "L" ? "outline" : "fill") },
        { keys: ["H"], says: "overhang", act: () => setting("overhang").click() },
        { keys: ["V"], says: "layer, 3D, both", act: () => set_view() },
        { keys: ["D"], says: "dark or light", act: set_dark },
        { keys: ["O"], says: "open a mesh", act: pick },
        { keys: ["E"], says: "export", act: () => dialog("export") },
        { keys: ["?"], says: "this list", act: () => dialog("help") },
        { keys: ["Escape"], says: "stop what is under way", act: escape },
    ]);
    const clicks: Record<string, () => void> = {
        open: pick, choose: pick, view: () => set_view(), dark: set_dark, "show-export": () => dialog("export"), "show-help": () => dialog("help"),
        up: () => go(state.index + 1), down: () => go(state.index - 1), "to-open": () => go(first_open()),
        "svg-layer": () => client.ask({ ask: "svg", first: state.index, end: state.index + 1 }),
        "svg-all": () => client.ask({ ask: "svg", first: 0, end: layer_count() }),
        png: () => state.layer !== null && save_png(layer_canvas), "csv-layers": () => save_csv("layers"),
        "csv-contours": () => state.layer !== null && save_csv("contours"),
    };
    for (const [id, action] of Object.entries(clicks)) {
        element(id).addEventListener("click", action);
    }
    element<HTMLInputElement>("file").onchange = (event) => {
        const input = event.target as HTMLInputElement;
        open_files([...(input.files ?? [])]);
        input.value = "";
    };
    element<HTMLSelectElement>("sources").onchange = (event) => choose(Number((event.target as HTMLSelectElement).value));
    element<HTMLInputElement>("z").onchange = (event) => jump((event.target as HTMLInputElement).value);
    element<HTMLInputElement>("index").onchange = (event) => jump(`#${(event.target as HTMLInputElement).value.replace("#", "")}`);
    addEventListener("dragover", (event) => event.preventDefault());
    addEventListener("drop", (event) => {
        event.preventDefault();
        open_files([...(event.dataTransfer?.files ?? [])]);
    });
    addEventListener("hashchange", () => {
        linked = parse_link(location.hash);
        state.mesh !== null && ((view.scale = 0), client.plan((asked_plan = plan_of_link(linked, state.plan))));
    });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => (forget_colours(), stack.forget_cap(), changed()));
}

function draw(): void {
    if (view.scale === 0 && layer_count() > 0) {
        fit(layer_canvas);
    }
    if (state.pointer !== null) {
        state.hovered = nearest(state.pointer, 7 / view.scale);
    }
    client.pixel = view.scale > 0 ? 1 / (view.scale * (devicePixelRatio || 1)) : 0;
    client.pursue();
    state.view !== "3d" && draw_layer(layer_canvas);
    state.view !== "layer" && stack.render();
    draw_curve(curve_canvas);
    draw_words();
}

begin_settings();
begin_panel({ select, go, check: () => client.check(), unit: (unit) => state.mesh !== null && client.reopen(unit) });
begin_pointer();
begin_page();
on_frame(draw);
watch_sizes(changed, layer_canvas, curve_canvas, stack_canvas);
fit_canvas(layer_canvas);
set_view("both");
Object.assign(globalThis, { lamella: { state, client, go } }); // for tests and the curious

async function start(): Promise<void> {
    await client.start();
    document.body.dataset["ready"] = "yes";
    for (const script of document.querySelectorAll<HTMLScriptElement>("script.mesh")) {
        const name = script.dataset["name"] ?? "mesh";
        sources.push({ file: new Blob([bytes_of(script.textContent!)], { type: gzip }), name, unit: 0 });
        script.remove();
    }
    sources.length > 0 && choose(0);
}
void start();
