// Pictures and controls of a lesson tell their names to a screen reader.
// A picture is named by the words that the lesson has beside it ("*Figure: ...*"), a slider by its label. Links in a text
// are underlined: their colour alone tells them from it for nobody who sees little colour.

const ends = /^\*(?:Figure|Film)[^:]*: ([\s\S]*?)\*\s*$/m;
const plain = text => text.replace(/\$([^$]*)\$/g, "$1").replace(/[*`\\]/g, "").replace(/\s+/g, " ").trim();

function caption(cells, index) {
  for (const other of [index + 1, index - 1]) {
    const found = other in cells && cells[other].model.type === "markdown" && ends.exec(cells[other].model.sharedModel.getSource());
    if (found) return plain(found[1]);
  }
  return "";
}

function heading(cells, index) {
  for (let k = index; k >= 0; k--) {
    const found = cells[k].model.type === "markdown" && /^#+ (.+)$/m.exec(cells[k].model.sharedModel.getSource());
    if (found) return plain(found[1]);
  }
  return "";
}

// What a panel or a clip says of itself stands in its plain text.
function told(cell, picture) {
  const areas = [...cell.node.querySelectorAll(".jp-OutputArea-child")];
  const outputs = cell.model.outputs;
  const place = areas.findIndex(area => area.contains(picture));
  if (!outputs || place < 0 || place >= outputs.length) return "";
  const words = String(outputs.get(place).data["text/plain"] || "");
  return /^(panel|clip): /.test(words) ? plain(words.replace(/^\w+: /, "")) : "";
}

function namePictures(cells) {
  cells.forEach((cell, index) => {
    for (const picture of cell.node.querySelectorAll(".jp-OutputArea img:not([alt])")) {
      const words = told(cell, picture) || caption(cells, index) || `Picture of the section ${heading(cells, index)}`;
      picture.setAttribute("alt", words);
    }
  });
}

function nameControls(node) {
  for (const box of node.querySelectorAll(".widget-play")) {
    box.querySelectorAll("button").forEach((button, k) => button.setAttribute("aria-label", ["play or pause", "stop", "repeat"][k] || ""));
  }
  for (const line of node.querySelectorAll(".widget-vbox > .widget-label")) line.setAttribute("aria-live", "polite"); // a panel's result
  for (const box of node.querySelectorAll(".jupyter-widgets.widget-inline-hbox")) {
    const label = box.querySelector(".widget-label");
    const words = label && label.textContent.trim();
    if (!words) continue;
    const handles = [...box.querySelectorAll(".noUi-handle")];
    handles.forEach((handle, k) => handle.setAttribute("aria-label", handles.length > 1 ? `${words}, ${k ? "upper" : "lower"} end` : words));
    for (const readout of box.querySelectorAll(".widget-readout[contenteditable]")) {
      readout.setAttribute("role", "textbox");
      readout.setAttribute("aria-label", `${words}, typed in`);
    }
  }
}

const plugin = {
  id: "stereo_lab_page:names",
  autoStart: true,
  activate: app => {
    const style = document.createElement("style");
    style.textContent = `
      .jp-Notebook :is(.jp-RenderedHTMLCommon, .jp-RenderedText) a { text-decoration: underline !important; }
      .jp-Notebook .widget-vbox > .widget-label { white-space: normal; height: auto; }`; // a long sentence goes on in the next line
    document.head.append(style);
    let waits = false;
    const name = () => {
      waits = false;
      for (const panel of app.shell.widgets("main")) {
        if (!panel.content || !panel.content.widgets || !panel.content.activeCellChanged) continue; // no notebook
        namePictures(panel.content.widgets);
        nameControls(panel.node);
      }
    };
    const later = () => {
      if (!waits) {
        waits = true;
        setTimeout(name, 200);
      }
    };
    new MutationObserver(later).observe(document.body, { childList: true, subtree: true });
  }
};

// What JupyterLab asks of an extension that it loads by itself.
window._JUPYTERLAB = window._JUPYTERLAB || {};
window._JUPYTERLAB["stereo_lab_page"] = {
  init: () => undefined,
  get: () => Promise.resolve(() => ({ __esModule: true, default: plugin }))
};
