"""The report of a clip or a run: as a document, text, HTML page, picture, JUnit XML and annotations."""
