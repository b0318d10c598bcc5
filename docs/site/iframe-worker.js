// Opened from a file system, a page may start no worker: the search's then runs in a hidden frame.
if (location.protocol === "file:")
  window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      const frame = document.createElement("iframe");
      frame.hidden = true;
      this.ready = new Promise((resolve) => {
        const place = () => {
          document.body.append(frame);
          this.inside = frame.contentWindow;
          this.inside.document.open();
          this.inside.document.write("<body></body>");
          this.inside.document.close();
          this.inside.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }));
          const script = this.inside.document.createElement("script");
          script.src = url;
          script.onload = resolve;
          this.inside.document.body.append(script);
        };
        if (document.body) place();
        else addEventListener("DOMContentLoaded", place);
      });
    }
    postMessage(data) {
      this.ready.then(() => this.inside.dispatchEvent(new MessageEvent("message", { data })));
    }
    terminate() {
      this.inside?.frameElement?.remove();
    }
  };
