// SPDX-License-Identifier: Apache-2.0
// Makes a form for each type of job from the schema of its parameters (GET /v1/types).

import { ask, askTypes } from "./client.js";
import { errorText } from "./error_text.js";
import { byId, bytesText, node, notify } from "./nodes.js";

const FEW = 6; // parameters that are visible at first
const PATH_LENGTH = 4095; // marks paths of files in the schema

const withoutEnding = (name) => name.replace(/(\.(png|tiff?|exr|jpe?g|webp|toml))+$/i, "");

/** Proposes an output next to the input or, for an upload, among the downloadable results. */
function outputFor(type, input) {
  const upload = /^(.*)\/uploads\/([0-9a-f]{8})[0-9a-f]*\/([^/]+)$/.exec(input);
  // For a manifest, the name of its folder is used.
  const stem = upload ? `${upload[1]}/results/${withoutEnding(upload[3])}-${upload[2]}`
    : withoutEnding(input.replace(/\/inferred\.json$/, ""));
  return type.output_is_folder ? `${stem}_textures` : stem + type.output_extension;
}

function inputFor(name, schema, isRequired) {
  const id = `parameter-${name}`;
  if (schema.type === "boolean") return node("input", { id, type: "checkbox" });
  const choices = schema.enum;
  if (choices)
    return node("select", { id }, node("option", { value: "" }, "default"),
      ...choices.map((one) => node("option", { value: one }, one)));
  if (schema.type === "integer" || schema.type === "number")
    return node("input", { id, type: "number", min: schema.minimum, max: schema.maximum, placeholder: "default",
      step: schema.type === "integer" ? 1 : "any" });
  return node("input", { id, type: "text", maxlength: schema.maxLength, required: isRequired, spellcheck: "false",
    autocomplete: "off", placeholder: schema.maxLength === PATH_LENGTH ? "/path/on/the/server.png" : null });
}

/** Returns the value of an input, or undefined if none was entered. */
function valueOf(input, schema) {
  if (schema.type === "boolean") return input.checked || undefined;
  if (input.value === "") return undefined;
  return schema.type === "integer" || schema.type === "number" ? Number(input.value) : input.value;
}

export class SubmitForm {
  /** Calls `submitted`(job) with the new job. */
  constructor(submitted) {
    this.submitted = submitted;
    this.dialog = byId("submit");
  }

  async open(queues) {
    try {
      this.types = (await askTypes()).types;
    } catch (error) {
      return notify(errorText(error), true);
    }
    this.kind = node("select", { id: "submit-type", onchange: () => this.build() },
      ...this.types.map((type) => node("option", { value: type.name }, type.name)));
    this.summary = node("div", { class: "hint" });
    this.queue = node("select", { id: "submit-queue" }, ...queues.map((one) => node("option", { value: one }, one)));
    this.label = node("input", { id: "submit-label", type: "text", maxlength: 1000, autocomplete: "off" });
    this.priority = node("input", { id: "submit-priority", type: "number", min: -1000, max: 1000, step: 1, value: 0 });
    this.output = node("input", { id: "submit-output", type: "text", maxlength: 1000, autocomplete: "off",
      spellcheck: "false" });
    this.fields = node("div");
    this.problem = node("p", { class: "error", role: "alert" });
    this.button = node("button", { class: "primary", type: "submit" }, "Submit");
    const form = node("form", { onsubmit: (event) => this.send(event) },
      node("h2", { id: "submit-title" }, "Submit a job"),
      node("div", { class: "fields" }, node("label", { for: "submit-type" }, "type"),
        node("div", {}, this.kind, this.summary)),
      this.fields, this.problem,
      node("div", { class: "actions" },
        node("button", { type: "button", onclick: () => this.dialog.close() }, "Cancel"), this.button));
    this.dialog.replaceChildren(form);
    this.build();
    this.dialog.showModal();
    this.kind.focus();
  }

  get type() { return this.types.find((one) => one.name === this.kind.value); }

  field(label, id, input, hint) {
    if (hint) input.setAttribute("aria-describedby", `${id}-hint`);
    return [node("label", { for: id }, label),
      node("div", {}, input.closest(".with-button") ?? input,
        hint ? node("div", { class: "hint", id: `${id}-hint` }, hint) : null)];
  }

  build() {
    const { parameters: schema, input: inputName, summary } = this.type;
    this.summary.textContent = summary;
    const required = schema.required ?? [];
    this.inputs = {};
    this.isOutputOwn = false;
    const rows = (names) => node("div", { class: "fields" }, ...names.flatMap((name) => {
      const one = schema.properties[name];
      const input = this.inputs[name] = inputFor(name, one, required.includes(name));
      if (one.maxLength === PATH_LENGTH) this.addUpload(input);
      return this.field(name.replaceAll("_", " "), input.id, input, one.description);
    }));
    const optional = Object.keys(schema.properties).filter((name) => !required.includes(name));
    const first = rows(required);
    this.output.required = inputName !== null;
    this.output.oninput = () => { this.isOutputOwn = this.output.value !== ""; };
    if (inputName) this.inputs[inputName].addEventListener("input", () => this.suggestOutput());
    first.append(
      ...this.field("output", "submit-output", this.output, inputName
        ? "a path on the server, below one of its roots; or a name, for a downloadable result"
        : "a path on the server, or a name; optional"),
      ...this.field("queue", "submit-queue", this.queue), ...this.field("priority", "submit-priority", this.priority),
      ...this.field("label", "submit-label", this.label, "shown in the list; optional"));
    this.fields.replaceChildren(first, node("details", { open: optional.length <= FEW },
      node("summary", {}, `Parameters (${optional.length})`), rows(optional)));
  }

  suggestOutput() {
    const input = this.inputs[this.type.input].value;
    if (!this.isOutputOwn) this.output.value = input ? outputFor(this.type, input) : "";
  }

  addUpload(input) {
    const file = node("input", { type: "file", hidden: true, "aria-label": "file to upload",
      onchange: () => file.files[0] && this.upload(file.files[0], input) });
    node("div", { class: "with-button" }, input, file,
      node("button", { type: "button", onclick: () => file.click() }, "Upload ..."));
  }

  async upload(file, input) {
    // The service accepts letters, digits, dots, dashes and underscores in names.
    const name = file.name.replace(/[^A-Za-z0-9._-]/g, "_").replace(/^\.+/, "").slice(-100) || "upload";
    this.problem.textContent = "";
    try {
      const answer = await ask("PUT", `/v1/uploads/${name}`, file);
      input.value = answer.path;
      input.dispatchEvent(new Event("input"));
      notify(`${file.name} was uploaded, ${bytesText(answer.bytes)}`);
    } catch (error) {
      this.problem.textContent = `${file.name} was not uploaded: ${errorText(error)}`;
    }
  }

  async send(event) {
    event.preventDefault();
    const parameters = {};
    for (const [name, input] of Object.entries(this.inputs)) {
      const value = valueOf(input, this.type.parameters.properties[name]);
      if (value !== undefined) parameters[name] = value;
    }
    const job = { type: this.type.name, parameters, priority: Number(this.priority.value) };
    if (this.queue.value) job.queue = this.queue.value;
    if (this.output.value) job.output = this.output.value;
    if (this.label.value) job.label = this.label.value;
    this.button.disabled = true;
    this.problem.textContent = "";
    try {
      const answer = await ask("POST", "/v1/jobs", job);
      this.dialog.close();
      notify(`Job ${answer.id} is ${answer.state}.`);
      this.submitted(answer);
    } catch (error) {
      this.problem.textContent = errorText(error);
    }
    this.button.disabled = false;
  }
}
